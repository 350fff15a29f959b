// Faces that are meshed in pieces.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "mesher/sizing/build_size_field.hpp"
#include "mesher/surface/edge_mesher.hpp"
#include "mesher/surface/face_in_pieces.hpp"
#include "mesher/surface/surface_mesher.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::test_models;

namespace {

const std::function<bool()> kGoOn = [] { return true; };

/// One face of a model, with its edges meshed.
struct Setting {
  Setting(const GeometricModel& given, const SizeField& field, std::uint32_t number = 0)
      : model(given),
        face(number),
        sizes(field),
        edges(mesh_edges(given, field, {}, TaskRunner(1))),
        rim(given, edges) {}

  FaceSurroundings surroundings() const { return {rim, sizes, chords, false}; }
  FaceMesh whole() const { return mesh_face(model, face, surroundings(), kGoOn); }
  std::optional<FaceCut> cut() const { return cut_large_face(model, face, surroundings(), TaskRunner(1)); }
  FaceMesh in_pieces(int threads = 1) const {
    const TaskRunner runner(threads);
    const FaceSurroundings around = surroundings();
    std::optional<FaceCut> made = cut();
    REQUIRE(made);
    FaceInPieces pieces(model, face, around, std::move(*made), kGoOn);
    runner.for_each(pieces.piece_count(), [&](std::size_t piece) { pieces.mesh_piece(piece); });
    std::optional<FaceMesh> mesh = pieces.join(runner);
    REQUIRE(mesh);
    return std::move(*mesh);
  }
  Vec3 point(const FaceMesh& mesh, std::uint32_t v) const {
    return v & FaceMesh::kInner ? mesh.points[v & ~FaceMesh::kInner] : rim.point(v);
  }

  const GeometricModel& model;
  ModelFaceId face;
  SizeField sizes;
  std::vector<EdgeMesh> edges;
  RimNodes rim;
  std::vector<std::array<std::uint32_t, 2>> chords;
};

using EdgeUses = std::map<std::pair<std::uint32_t, std::uint32_t>, int>;

EdgeUses count_edge_uses(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  EdgeUses uses;
  for (const auto& tri : triangles)
    for (std::size_t i = 0; i < 3; ++i) ++uses[std::minmax(tri[i], tri[(i + 1) % 3])];
  return uses;
}

struct Figures {
  double area = 0, mean = 0, first_percentile = 0, smallest_angle = 180, in_band = 0;
};

Figures measure(const Setting& setting, const FaceMesh& mesh) {
  Figures figures;
  std::vector<double> qualities;
  for (const auto& tri : mesh.tri_to_vert) {
    double squares = 0;
    const Vec3 a = setting.point(mesh, tri[0]), b = setting.point(mesh, tri[1]), c = setting.point(mesh, tri[2]);
    const double area = 0.5 * norm(cross(b - a, c - a));
    for (const auto& [p, q, r] : {std::array{a, b, c}, std::array{b, c, a}, std::array{c, a, b}}) {
      squares += norm2(q - p);
      const double angle = std::atan2(norm(cross(q - p, r - p)), dot(q - p, r - p)) * 180 / std::numbers::pi;
      figures.smallest_angle = std::min(figures.smallest_angle, angle);
    }
    figures.area += area;
    qualities.push_back(4 * std::sqrt(3.0) * area / squares);
    figures.mean += qualities.back() / static_cast<double>(mesh.tri_to_vert.size());
  }
  std::ranges::sort(qualities);
  figures.first_percentile = qualities[qualities.size() / 100];
  const EdgeUses uses = count_edge_uses(mesh.tri_to_vert);
  for (const auto& [edge, count] : uses) {
    const Vec3 a = setting.point(mesh, edge.first), b = setting.point(mesh, edge.second);
    const double length = distance(a, b) / setting.sizes.size_at(0.5 * (a + b));
    if (length >= std::sqrt(0.5) && length <= std::sqrt(2.0)) figures.in_band += 1.0 / static_cast<double>(uses.size());
  }
  return figures;
}

void check_like_whole(const Setting& setting) {
  const FaceMesh whole = setting.whole(), pieces = setting.in_pieces();
  CHECK(pieces.verdict == FaceVerdict::Ok);
  CHECK(pieces.inverted == 0);
  const auto triangles = static_cast<double>(whole.tri_to_vert.size());
  CHECK(static_cast<double>(pieces.tri_to_vert.size()) == Approx(triangles).epsilon(0.02));
  const Figures expected = measure(setting, whole), figures = measure(setting, pieces);
  CHECK(figures.area == Approx(expected.area).epsilon(1e-4));
  CHECK(figures.mean > expected.mean - 0.005);
  CHECK(figures.first_percentile > expected.first_percentile - 0.025);
  CHECK(figures.in_band > expected.in_band - 0.005);
  CHECK(figures.smallest_angle > std::min(25.0, expected.smallest_angle));
  std::set<std::uint32_t> used;
  for (const auto& tri : pieces.tri_to_vert) used.insert(tri.begin(), tri.end());
  const auto inner = std::ranges::count_if(used, [](std::uint32_t v) { return (v & FaceMesh::kInner) != 0; });
  CHECK(static_cast<std::size_t>(inner) == pieces.points.size());
}

bool is_closed(const Mesh& mesh) {
  return std::ranges::all_of(count_edge_uses(mesh.tri_to_vert), [](const auto& use) { return use.second == 2; });
}

}  // namespace

TEST_CASE("large faces are cut into pieces by their number of triangles, others are not") {
  const auto plate = make_plate(2, 1);
  CHECK_FALSE(Setting(*plate, SizeField::uniform(0.016)).cut());  // 18 000
  for (const double size : {0.012, 0.007}) {
    const auto cut = Setting(*plate, SizeField::uniform(size)).cut();
    REQUIRE(cut);
    const double triangles = 2 * kTrianglesPerSquare / (size * size);
    CHECK(static_cast<double>(cut->pieces.size()) == Approx(triangles / kTrianglesPerPiece).margin(1));
  }
}

TEST_CASE("in pieces a planar face is meshed as well as in one") {
  check_like_whole({*make_plate(2, 1), SizeField::uniform(0.008)});
  check_like_whole({*make_annulus(0.5, 1), SizeField::uniform(0.009)});
}

TEST_CASE("in pieces a face with seams or poles is meshed as well as in one") {
  check_like_whole({*make_sphere({1, 2, 3}, 0.7), SizeField::uniform(0.016)});
  check_like_whole({*make_torus(1, 0.4), SizeField::uniform(0.025)});
  check_like_whole({*make_cylinder(0.5, 1), SizeField::uniform(0.011)});
  check_like_whole({*make_cone(0.5, 1.5), SizeField::uniform(0.009)});
}

TEST_CASE("in pieces a face with sizes that vary is meshed as well as in one") {
  const auto plate = make_plate(2, 1);
  SizeOptions options;
  options.size = 0.05;
  options.gradation = 0.02;
  options.point_sizes.push_back({{0.5, 0.5, 0}, 0.0008});
  const SizeField sizes = build_size_field(*plate, options, {}, TaskRunner(1));
  const Setting setting(*plate, sizes);
  REQUIRE(setting.cut());
  check_like_whole(setting);
}

TEST_CASE("in pieces closed surfaces stay closed, across seams, poles and cuts") {
  CHECK(is_closed(mesh_surface(*make_sphere({}, 0.5), SizeField::uniform(0.012), TaskRunner(2)).mesh));
  CHECK(is_closed(mesh_surface(*make_torus(1, 0.4), SizeField::uniform(0.025), TaskRunner(2)).mesh));
  CHECK(is_closed(mesh_surface(*make_cylinder(0.5, 1), SizeField::uniform(0.011), TaskRunner(2)).mesh));
}

TEST_CASE("the same mesh of a face in pieces on any number of threads") {
  const std::vector<std::shared_ptr<const GeometricModel>> bodies{make_sphere({}, 0.5),
                                                                  make_box({2, 0, 0}, {2.2, 0.2, 0.2})};
  const auto model = combine(bodies);
  const SizeField sizes = SizeField::uniform(0.011);
  const Mesh reference = mesh_surface(*model, sizes, TaskRunner(1)).mesh;
  for (const int threads : {2, 8}) {
    const Mesh mesh = mesh_surface(*model, sizes, TaskRunner(threads)).mesh;
    CHECK(mesh.points == reference.points);
    CHECK(mesh.tri_to_vert == reference.tri_to_vert);
    CHECK(mesh.point_to_entity == reference.point_to_entity);
  }
}

TEST_CASE("no cut ends at a pole") {
  const auto sphere = make_sphere({}, 0.5);
  const auto cut = Setting(*sphere, SizeField::uniform(0.011)).cut();
  REQUIRE(cut);
  for (std::size_t v = 0; v < cut->vertices.size(); ++v)
    if (std::abs(cut->vertices[v].place.point.z) > 0.4999) CHECK(cut->kinds[v].junction == CutVertex::kNone);
}

TEST_CASE("a face with a piece that cannot be meshed has no mesh in pieces") {
  const auto plate = make_plate(2, 1);
  const Setting setting(*plate, SizeField::uniform(0.012));
  const FaceSurroundings around = setting.surroundings();
  FaceInPieces pieces(*plate, ModelFaceId(0), around, *setting.cut(), kGoOn);
  for (std::size_t piece = 1; piece < pieces.piece_count(); ++piece) pieces.mesh_piece(piece);
  pieces.fail_piece(0);
  CHECK_FALSE(pieces.join(TaskRunner(1)));
}

TEST_CASE("in pieces edges that another face has are split") {
  // The corner is so sharp that edges cross it from side to side.
  const std::vector<Vec3> corners{{0, 0, 0}, {4, 0, 0}, {4, 1, 0}};
  const std::vector<std::vector<std::uint32_t>> ring{{0, 1, 2}};
  const auto sheet = make_polyhedron(corners, ring, false);
  Setting setting(*sheet, SizeField::uniform(0.0121));
  const auto chords_of = [&](const FaceMesh& mesh) {
    std::vector<std::array<std::uint32_t, 2>> chords;
    for (const auto& [edge, count] : count_edge_uses(mesh.tri_to_vert))
      if (count == 2 && !((edge.first | edge.second) & FaceMesh::kInner)) chords.push_back({edge.first, edge.second});
    return chords;
  };
  const FaceMesh before = setting.in_pieces();
  setting.chords = chords_of(before);
  REQUIRE_FALSE(setting.chords.empty());
  const FaceMesh after = setting.in_pieces();
  CHECK(chords_of(after).empty());
  CHECK(after.points.size() == before.points.size() + setting.chords.size());
  CHECK(after.tri_to_vert.size() == before.tri_to_vert.size() + 2 * setting.chords.size());
  CHECK(measure(setting, after).area == Approx(2).epsilon(1e-9));
}

TEST_CASE("a face in pieces can be cancelled at any time") {
  const auto sphere = make_sphere({}, 0.5);
  const SizeField sizes = SizeField::uniform(0.008);
  for (const int asked : {1, 20, 60, 200}) {
    std::atomic<int> left{asked};
    Host host;
    host.wants_stop = [&] { return left.fetch_sub(1) <= 0; };
    CHECK_THROWS_AS(mesh_surface(*sphere, sizes, TaskRunner(2, host)), Error);
  }
}
