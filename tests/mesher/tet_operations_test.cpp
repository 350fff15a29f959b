// Each operation on a few tets: removal of edges and vertices, motion, points that go in.
#include <catch2/catch.hpp>

#include <random>

#include "core/tets/deep_point.hpp"
#include "mesher/tets/edge_removal.hpp"
#include "mesher/tets/newton_smoothing.hpp"
#include "mesher/tets/point_insertion.hpp"
#include "mesher/tets/vertex_removal.hpp"
#include "tests/support/tet_fixtures.hpp"

namespace tetloom {
namespace {

using namespace tet_tests;
using tets::EdgeVerdict;
using tets::MoveVerdict;
using tets::WorkingMesh;

constexpr std::uint32_t kNoneFixed = 0;

EdgeVerdict try_removal(TetMesh& mesh, std::uint32_t tet = 0) {
  WorkingMesh working(mesh, kNoneFixed);
  const EdgeVerdict verdict = tets::remove_edge_of(working, tet);
  if (verdict == EdgeVerdict::Removed) working.finish();
  return verdict;
}

// In the precision in which the working mesh compares them.
std::uint32_t worst_tet(TetMesh& mesh) {
  const WorkingMesh working(mesh, kNoneFixed);
  std::uint32_t worst = 0;
  for (std::uint32_t t = 1; t < mesh.size(); ++t) {
    if (working.quality(t) < working.quality(worst)) worst = t;
  }
  return worst;
}

TEST_CASE("removing a long edge leaves two tets over every triangle of its ring") {
  for (const std::uint32_t count : {3u, 4u, 5u, 6u, 7u}) {
    TetMesh mesh = make_ring(count, 3);
    REQUIRE(tets::find_fault(mesh).empty());
    const double least = least_quality(mesh), volume = volume_of_region(mesh, 0);
    const auto faces = fixed_faces(mesh);
    CHECK(try_removal(mesh, worst_tet(mesh)) == EdgeVerdict::Removed);
    CHECK(mesh.size() == 2 * (count - 2));
    CHECK(tets::find_fault(mesh) == "");
    CHECK(least_quality(mesh) > least);
    CHECK(volume_of_region(mesh, 0) == Approx(volume));
    CHECK(fixed_faces(mesh) == faces);
  }
}

TEST_CASE("an edge with eight tets is left alone") {
  TetMesh mesh = make_ring(8, 3);
  const TetMesh before = mesh;
  CHECK(try_removal(mesh, worst_tet(mesh)) == EdgeVerdict::LongRing);
  CHECK(same(mesh, before));
}

TEST_CASE("an edge whose removal gains nothing is left alone") {
  TetMesh mesh = make_ring(5, 0.5);
  const TetMesh before = mesh;
  CHECK(try_removal(mesh, worst_tet(mesh)) == EdgeVerdict::NoGain);
  CHECK(same(mesh, before));
}

TEST_CASE("an edge is left to the worst tet around it") {
  TetMesh mesh = make_ring(5, 3);
  mesh.points[0] = {1.02, 0, 0};
  const TetMesh before = mesh;
  CHECK(try_removal(mesh, worst_tet(mesh) == 2 ? 1 : 2) == EdgeVerdict::WorseBeside);
  CHECK(same(mesh, before));
}

TEST_CASE("edges of the surface stay") {
  TetMesh mesh = make_tets({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 0.01}}, {{0, 1, 2, 3}});
  const TetMesh before = mesh;
  CHECK(try_removal(mesh) == EdgeVerdict::OnSurface);
  CHECK(same(mesh, before));
}

TEST_CASE("an edge of a face that has to stay, stays") {
  TetMesh mesh = make_ring(4, 3);
  for (const tets::FaceCode face : tets::FaceCode::of(0)) {
    if (mesh.behind(face).valid()) {
      fix_face(mesh, face);
      break;
    }
  }
  REQUIRE(tets::find_fault(mesh).empty());
  const TetMesh before = mesh;
  CHECK(try_removal(mesh, worst_tet(mesh)) == EdgeVerdict::OnSurface);
  CHECK(same(mesh, before));
}

TEST_CASE("a vertex goes to the middle of its star") {
  TetMesh mesh = make_octahedron({0.3, 0.2, -0.4});
  WorkingMesh working(mesh, 6);
  tets::VertexMover mover(working, 0.2);
  const double least = least_quality(mesh);
  for (int i = 0; i < 15; ++i) {
    mover.move(0, working.corner_of(0, 6));
    CHECK(least_quality(mesh) >= std::min(least, std::cbrt(0.2)));
  }
  CHECK(norm(mesh.points[6]) < 1e-3);
  for (std::uint32_t t = 0; t < 8; ++t) CHECK(std::cbrt(working.quality(t)) == Approx(quality_of(mesh, t)));
}

TEST_CASE("a vertex leaves a flat tet in which it nearly lies on its face") {
  TetMesh mesh = make_octahedron({0.3333, 0.3333, 0.3333});
  REQUIRE(tets::find_fault(mesh).empty());
  WorkingMesh working(mesh, 6);
  tets::VertexMover mover(working, 0.2);
  const double least = least_quality(mesh);
  CHECK(mover.move(0, working.corner_of(0, 6)) == MoveVerdict::Moved);
  CHECK(tets::find_fault(mesh) == "");
  CHECK(least_quality(mesh) > least);
}

TEST_CASE("a vertex that was left on the boundary of its star goes deep into it, in one move") {
  for (const double off : {1e-3, 1e-5, 1e-8}) {
    CAPTURE(off);
    const double at = (1 - off) / 3;
    TetMesh mesh = make_octahedron({at, at, at});
    REQUIRE(tets::find_fault(mesh).empty());
    REQUIRE(least_quality(mesh) < 0.02);
    WorkingMesh working(mesh, 6);
    CHECK(tets::VertexMover(working, 0.2).move(0, working.corner_of(0, 6)) == MoveVerdict::Moved);
    CHECK(tets::find_fault(mesh) == "");
    CHECK(least_quality(mesh) > 0.5);
    CHECK(std::cbrt(working.quality(0)) == Approx(quality_of(mesh, 0)));
  }
}

// The tets over the faces of a shaken octahedron whose faces are cut in four, measured from `x`.
std::vector<tets::StarTet> make_star(std::mt19937_64& random, double shake, const Vec3& x) {
  std::uniform_real_distribution<double> amount(-shake, shake);
  std::vector<Vec3> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> middles;
  const auto middle = [&](std::size_t a, std::size_t b) {
    const auto [entry, is_new] = middles.emplace(std::minmax(a, b), points.size());
    if (is_new) points.push_back(normalized(points[a] + points[b]));
    return entry->second;
  };
  std::vector<std::array<std::size_t, 3>> faces;
  for (const auto& [a, b, c] : {std::array<std::size_t, 3>{0, 2, 4},
                                {2, 1, 4},
                                {1, 3, 4},
                                {3, 0, 4},
                                {2, 0, 5},
                                {1, 2, 5},
                                {3, 1, 5},
                                {0, 3, 5}}) {
    const std::size_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    faces.insert(faces.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  for (Vec3& p : points) p += Vec3{amount(random), amount(random), amount(random)};
  std::vector<tets::StarTet> star;
  for (const auto& [a, b, c] : faces) star.push_back(tets::star_tet(points[a] - x, points[c] - x, points[b] - x));
  return star;
}

double depth_of(const std::vector<tets::StarTet>& star, const Vec3& d) {
  double depth = HUGE_VAL;
  for (const tets::StarTet& tet : star) depth = std::min(depth, tet.volume_at(d) / norm(tet.normal));
  return depth;
}

TEST_CASE("the deepest place of a star is found from anywhere, or that there is none inside of all faces") {
  const unsigned seed = 2031;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> anywhere(-2, 2), unit(-1, 1);
  int found = 0, none = 0;
  for (int i = 0; i < 400; ++i) {
    CAPTURE(i);
    const auto star = make_star(random, i % 2 == 0 ? 0.1 : 0.5, {anywhere(random), anywhere(random), anywhere(random)});
    const auto deep = tets::find_deep_point(star);
    REQUIRE(deep);
    CHECK(deep->depth == Approx(depth_of(star, deep->point)).margin(1e-12));
    const bool is_star_shaped = deep->depth > 0;
    is_star_shaped ? ++found : ++none;
    Vec3 best = deep->point;
    double depth = deep->depth;
    for (double reach = 2; reach > 1e-3; reach *= 0.99) {  // random steps uphill
      const Vec3 next = best + reach * Vec3{unit(random), unit(random), unit(random)};
      if (depth_of(star, next) > depth) best = next, depth = depth_of(star, best);
    }
    CHECK(depth <= (is_star_shaped ? 1.1 * deep->depth : 1e-6));
  }
  CHECK(found > 100);
  CHECK(none > 50);
}

TEST_CASE("a vertex that is best where it is, stays") {
  TetMesh mesh = make_octahedron({0, 0, 0});
  const TetMesh before = mesh;
  WorkingMesh working(mesh, 6);
  CHECK(tets::VertexMover(working, 1).move(0, working.corner_of(0, 6)) == MoveVerdict::NoGain);
  CHECK(same(mesh, before));
}

TEST_CASE("points of the surface and those of faces that have to stay do not move") {
  TetMesh mesh = make_octahedron({0.3, 0.2, -0.4});
  {
    const TetMesh before = mesh;
    WorkingMesh working(mesh, 7);
    CHECK(tets::VertexMover(working, 1).move(0, working.corner_of(0, 6)) == MoveVerdict::OnSurface);
    CHECK(same(mesh, before));
  }
  for (const tets::FaceCode face : tets::FaceCode::of(0)) {
    if (mesh.behind(face).valid()) fix_face(mesh, face);
  }
  const TetMesh before = mesh;
  WorkingMesh working(mesh, 0);
  CHECK(tets::VertexMover(working, 1).move(0, working.corner_of(0, 6)) == MoveVerdict::OnSurface);
  CHECK(same(mesh, before));
}

TEST_CASE("a point goes into tets that are too long") {
  TetMesh mesh = make_ring(6, 6);
  const double least = least_quality(mesh), volume = volume_of_region(mesh, 0);
  const auto faces = fixed_faces(mesh);
  WorkingMesh working(mesh, 8);
  const std::uint32_t tet = worst_tet(mesh);
  REQUIRE(tets::PointInserter(working, 1.1 * working.quality(tet)).insert(tet));
  working.finish();
  CHECK(mesh.points.size() == 9);
  CHECK(mesh.size() == 12);
  CHECK(tets::find_fault(mesh) == "");
  CHECK(least_quality(mesh) > least);
  CHECK(volume_of_region(mesh, 0) == Approx(volume));
  CHECK(fixed_faces(mesh) == faces);
}

TEST_CASE("no point goes into a tet that is regular") {
  TetMesh mesh = make_tets({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2, 3}});
  const TetMesh before = mesh;
  WorkingMesh working(mesh, 4);
  CHECK_FALSE(tets::PointInserter(working, 1).insert(0));
  CHECK(same(mesh, before));
}

TEST_CASE("a vertex too near to another is merged into a neighbour") {
  // An octahedron whose middle lies near its top: without it, four tets around the axis remain.
  TetMesh mesh = make_octahedron({0.05, 0.02, 0.85});
  REQUIRE(tets::find_fault(mesh).empty());
  const double least = least_quality(mesh), volume = volume_of_region(mesh, 0);
  WorkingMesh working(mesh, 6);
  REQUIRE(tets::VertexRemover(working).remove_vertex_of(worst_tet(mesh)));
  working.finish();
  CHECK(mesh.size() == 4);
  CHECK(mesh.points.size() == 6);
  CHECK(tets::find_fault(mesh) == "");
  CHECK(least_quality(mesh) > least);
  CHECK(volume_of_region(mesh, 0) == Approx(volume));
}

// The icosahedron around its centre, which is point 12.
TetMesh make_icosahedron() {
  const double g = 1.618033988749895;
  std::vector<Vec3> points;
  for (const double s : {-1.0, 1.0}) {
    for (const double t : {-g, g}) points.insert(points.end(), {{0, s, t}, {s, t, 0}, {t, 0, s}});
  }
  std::vector<std::array<std::uint32_t, 4>> tets;
  const auto near = [&](std::uint32_t i, std::uint32_t j) { return distance(points[i], points[j]) < 2.1; };
  for (std::uint32_t i = 0; i < 12; ++i)
    for (std::uint32_t j = i + 1; j < 12; ++j)
      for (std::uint32_t k = j + 1; k < 12; ++k)
        if (near(i, j) && near(j, k) && near(i, k)) tets.push_back({12, i, j, k});
  points.push_back({0, 0, 0});
  return make_tets(points, tets);
}

TEST_CASE("a vertex that serves its star is not removed") {
  TetMesh mesh = make_icosahedron();
  REQUIRE(mesh.size() == 20);
  const TetMesh before = mesh;
  WorkingMesh working(mesh, 12);
  CHECK_FALSE(tets::VertexRemover(working).remove_vertex_of(0));
  CHECK(same(mesh, before));
}

TEST_CASE("a vertex of the surface is not removed") {
  TetMesh mesh = make_octahedron({0.05, 0.02, 0.85});
  const TetMesh before = mesh;
  WorkingMesh working(mesh, 7);
  CHECK_FALSE(tets::VertexRemover(working).remove_vertex_of(worst_tet(mesh)));
  CHECK(same(mesh, before));
}

}  // namespace
}  // namespace tetloom
