#include "mesher/tets/optimizer.hpp"
#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>

#include "core/tets/deep_point.hpp"
#include "core/tets/dihedral.hpp"
#include "mesher/tets/edge_removal.hpp"
#include "mesher/tets/newton_smoothing.hpp"
#include "mesher/tets/point_insertion.hpp"
#include "mesher/tets/vertex_removal.hpp"
#include "tests/support/tet_fixtures.hpp"
#include "tetloom/error.hpp"

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
  for (std::uint32_t f = 0; f < 4; ++f) {
    if (mesh.to_neighbor[f] != kNone) {
      fix_face(mesh, f);
      break;
    }
  }
  REQUIRE(tets::find_fault(mesh).empty());
  const TetMesh before = mesh;
  CHECK(try_removal(mesh, worst_tet(mesh)) == EdgeVerdict::OnSurface);
  CHECK(same(mesh, before));
}

// The octahedron around `center`, which is point 6.
TetMesh make_octahedron(const Vec3& center) {
  return make_tets(
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}, center},
      {{6, 0, 2, 4}, {6, 2, 1, 4}, {6, 1, 3, 4}, {6, 3, 0, 4}, {6, 0, 2, 5}, {6, 2, 1, 5}, {6, 1, 3, 5}, {6, 3, 0, 5}});
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
  for (std::uint32_t f = 0; f < 4; ++f) {
    if (mesh.to_neighbor[f] != kNone) fix_face(mesh, f);
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

TEST_CASE("the smallest dihedral angle is found") {
  TetMesh regular = make_tets({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}, {{0, 1, 2, 3}});
  CHECK(tets::smallest_dihedral(regular, 0).angle == Approx(std::acos(1.0 / 3)));
  TetMesh wedge = make_tets({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, std::cos(0.2), std::sin(0.2)}}, {{0, 1, 2, 3}});
  CHECK(tets::smallest_dihedral(wedge, 0).angle == Approx(0.2));
}

TEST_CASE("no tet of good quality has a small dihedral angle") {
  std::mt19937 random(11);
  const auto coordinate = [&] { return static_cast<double>(random()) / 4294967296.0; };
  for (int i = 0; i < 20000; ++i) {
    std::vector<Vec3> points(4);
    for (Vec3& p : points) p = {coordinate(), coordinate(), coordinate()};
    const TetMesh mesh = make_tets(points, {{0, 1, 2, 3}});
    const double angle = tets::smallest_dihedral(mesh, 0).angle, quality = quality_of(mesh, 0);
    if (quality * quality * quality > tets::largest_quality_with_dihedral(angle) * (1 + 1e-9)) {
      CAPTURE(i, angle, quality);
      FAIL("the bound is wrong");
    }
  }
}

TEST_CASE("a quick look finds all tets with a dihedral angle below one") {
  std::mt19937 random(12);
  const auto coordinate = [&] { return static_cast<double>(random()) / 4294967296.0; };
  std::size_t told_apart = 0;
  for (int i = 0; i < 5000; ++i) {
    std::vector<Vec3> points(4);
    for (Vec3& p : points) p = {coordinate(), coordinate(), i % 5 == 0 ? 0.0 : coordinate()};
    const TetMesh mesh = make_tets(points, {{0, 1, 2, 3}});
    const double angle = tets::smallest_dihedral(mesh, 0).angle;
    CAPTURE(i, angle);
    if (!tets::may_be_below(mesh, 0, std::cos(angle + 1e-6))) FAIL("a smaller angle is overlooked");
    told_apart += !tets::may_be_below(mesh, 0, std::cos(angle * 0.999));
  }
  CHECK(told_apart > 3900);
}

TEST_CASE("small angles are told from those that the surface forces") {
  TetMesh mesh = make_tets({{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, std::cos(0.1), std::sin(0.1)}}, {{0, 1, 2, 3}});
  WorkingMesh working(mesh, 4);
  tets::DihedralSummary summary = tets::summarize_dihedrals(working, 0.25);
  CHECK(summary.least == Approx(0.1));
  CHECK(summary.below == 1);
  CHECK(summary.forced() == 1);
  mesh.to_fixed[0] = 0;
  mesh.points[3] = {0.5, 0.9, 0.35};
  mesh.points[2] = {0.5, 1, 0.2};
  WorkingMesh free(mesh, 0);
  summary = tets::summarize_dihedrals(free, 1.2);
  CHECK(summary.below == 1);
}

TEST_CASE("the cause of a small angle is found: an angle of the surface, a poor triangle, close points, or none") {
  // Two tets share the 0.2 between the two surface triangles at the edge from (0, 0, 0) to (1, 0, 0).
  const auto at = [](double angle) { return Vec3{0.5, std::cos(angle), std::sin(angle)}; };
  TetMesh wedge = make_tets({{0, 0, 0}, {1, 0, 0}, at(0), at(0.1), at(0.2)}, {{0, 1, 2, 3}, {0, 1, 3, 4}});
  const auto summary_of = [](TetMesh& mesh, double least_wanted, std::size_t free_points = 0) {
    WorkingMesh working(mesh, static_cast<std::uint32_t>(mesh.points.size() - free_points));
    return tets::summarize_dihedrals(working, least_wanted);
  };
  const tets::DihedralSummary at_angle = summary_of(wedge, 0.25);
  CHECK(at_angle.below == 2);
  CHECK(at_angle.angles == 2);
  REQUIRE(at_angle.worst.size() == 2);
  CHECK(at_angle.worst[0].cause == AngleCause::SurfaceAngle);
  CHECK(at_angle.worst[0].angle == Approx(0.1 * 180 / 3.14159265358979));
  CHECK(at_angle.worst[0].cause_angle == Approx(0.2 * 180 / 3.14159265358979));
  REQUIRE(at_angle.worst[0].triangles.size() == 2);
  CHECK(summary_of(wedge, 0.15).angles == 0);  // the surface's angle alone would allow that

  // A tet with a flat face on the surface, and one that is flat although its face is not.
  const std::vector<Vec3> flat{{0, 0, 0}, {1, 0, 0}, {0.5, 0.9, 0}, {0.5, 0.3, 0.05}};
  TetMesh needle = make_tets({{0, 0, 0}, {1, 0, 0}, {0.5, 0.1, 0}, {0.5, 0.04, 0.005}}, {{0, 1, 2, 3}});
  needle.to_fixed[0] = 8;  // the face of the first three points
  const tets::DihedralSummary at_triangle = summary_of(needle, 0.25);
  CHECK(at_triangle.triangles == 1);
  CHECK(at_triangle.worst.at(0).cause_angle == Approx(std::atan(0.2) * 180 / 3.14159265358979));
  CHECK(at_triangle.worst.at(0).triangles.size() == 1);

  // The same flat tet at a point inside, which may go elsewhere.
  TetMesh free = make_tets({{0, 0, 0}, {9, 0, 0}, {4.5, 8, 0}, {4.5, 3, 7}, {4.5, 3, 0.2}},
                           {{0, 1, 2, 4}, {0, 1, 4, 3}, {4, 1, 2, 3}, {0, 4, 2, 3}});
  free.to_fixed[0] = 8;
  const tets::DihedralSummary not_forced = summary_of(free, 0.25, 1);
  CHECK(not_forced.below == 1);
  CHECK(not_forced.forced() == 0);
  CHECK(distance(not_forced.worst.at(0).point, Vec3{4.5, 2.75, 0.05}) < 1e-12);
  TetMesh narrow = make_tets(flat, {{0, 1, 2, 3}});  // the same where the fourth point is of the surface
  narrow.to_fixed[0] = 8;
  const tets::DihedralSummary at_region = summary_of(narrow, 0.25);
  CHECK(at_region.forced() == 1);
  CHECK(at_region.worst.at(0).cause == AngleCause::NarrowRegion);
  CHECK(at_region.worst.at(0).cause_length == Approx(0.05));

  TetMesh close = make_tets({{0, 0, 0}, {1, 0, 0}, {0.5, 0.9, 0}, {0, 0.01, 0.1}}, {{0, 1, 2, 3}});
  close.to_fixed[0] = 8;
  const tets::DihedralSummary at_points = summary_of(close, 0.25);
  CHECK(at_points.points == 1);
  CHECK(at_points.worst.at(0).points == std::vector<std::uint32_t>{0, 3});
}

TEST_CASE("angles above the least of another mesh and above those asked for are not looked at") {
  ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 5);
  WorkingMesh working(grid.mesh, grid.fixed_points);
  const tets::DihedralSummary alone = tets::summarize_dihedrals(working, 0.01);
  CHECK(tets::summarize_dihedrals(working, 0.01, alone.least + 0.1).least == alone.least);
  CHECK(tets::summarize_dihedrals(working, 0.01, alone.least / 2).least == alone.least / 2);
  const tets::DihedralSummary told = tets::summarize_dihedrals(working, 0.9, alone.least / 2);
  CHECK(told.below == tets::summarize_dihedrals(working, 0.9).below);
  CHECK(told.below > 0);
}

TEST_CASE("of many small angles the worst are told, in order") {
  const ShakenGrid grid = make_shaken_grid(6, 1, 0.9, 5);
  TetMesh mesh = grid.mesh;
  WorkingMesh working(mesh, grid.fixed_points);
  const tets::DihedralSummary summary = tets::summarize_dihedrals(working, 1.1);
  CHECK(summary.below > 1000);
  REQUIRE(summary.worst.size() == kMostAcuteTets);
  std::vector<double> angles;
  for (std::uint32_t t = 0; t < mesh.size(); ++t)
    angles.push_back(tets::smallest_dihedral(mesh, t).angle * 180 / 3.14159265358979324);
  std::sort(angles.begin(), angles.end());
  for (std::size_t i = 0; i < kMostAcuteTets; ++i) REQUIRE(summary.worst[i].angle == Approx(angles[i]));
}

TEST_CASE("points that are given up are filled by the last ones") {
  TetMesh mesh = make_octahedron({0, 0, 0});
  const Vec3 last = mesh.points[6];
  const std::uint32_t unused = static_cast<std::uint32_t>(mesh.points.size());
  for (int i = 0; i < 3; ++i) mesh.points.push_back({double(i), 9, 9});
  WorkingMesh working(mesh, 6);
  working.give_up_point(unused + 2);
  working.give_up_point(unused);
  working.finish();
  CHECK(mesh.points.size() == 8);
  CHECK(mesh.points[6] == last);
  CHECK(mesh.points[7] == Vec3{1, 9, 9});
  CHECK(tets::find_fault(mesh) == "");
}

TEST_CASE("optimising random meshes keeps what must stay and lowers no minimum") {
  for (unsigned seed = 0; seed < 24; ++seed) {
    const int regions = seed % 2 == 0 ? 1 : 2;
    ShakenGrid grid = make_shaken_grid(5, regions, 0.3 + 0.009 * seed, seed);
    REQUIRE(volume_of_region(grid.mesh, 0) == Approx(regions == 1 ? 125 : 50));
    REQUIRE(tets::find_fault(grid.mesh) == "");
    CAPTURE(seed);
    TetMesh mesh = grid.mesh;
    tets::OptimizeOptions options;
    options.fixed_points = grid.fixed_points;
    const SizeField sizes = SizeField::uniform(1);
    if (seed % 3 == 0) options.sizes = &sizes;
    const tets::OptimizeReport report = tets::optimize(mesh, options, TaskRunner(1));
    CHECK(tets::find_fault(mesh) == "");
    CHECK(least_quality(mesh) >= least_quality(grid.mesh) * (1 - 1e-6));
    CHECK(report.least == Approx(least_quality(mesh)).epsilon(1e-5));
    CHECK(report.least_before == Approx(least_quality(grid.mesh)).epsilon(1e-5));
    CHECK(report.mean > report.mean_before);
    CHECK(report.vertices_moved > 0);
    for (int r = 0; r < regions; ++r) {
      const auto region = static_cast<std::uint32_t>(r);
      CHECK(volume_of_region(mesh, region) == Approx(volume_of_region(grid.mesh, region)).epsilon(1e-12));
    }
    CHECK(fixed_faces(mesh) == fixed_faces(grid.mesh));
    for (std::uint32_t v = 0; v < grid.fixed_points; ++v) CHECK(mesh.points[v] == grid.mesh.points[v]);
    TetMesh again = grid.mesh;
    tets::optimize(again, options, TaskRunner(2));
    CHECK(same(mesh, again));
  }
}

TEST_CASE("each operation tried everywhere keeps the invariants and lowers no minimum") {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const int regions = seed % 2 == 0 ? 1 : 2;
    ShakenGrid grid = make_shaken_grid(4, regions, 0.5, 100 + seed);
    TetMesh& mesh = grid.mesh;
    CAPTURE(seed);
    const auto faces = fixed_faces(mesh);
    const double volume = volume_of_region(mesh, 0);
    double least = least_quality(mesh);
    WorkingMesh working(mesh, grid.fixed_points);
    const TaskRunner runner(1);
    const auto check = [&](const char* stage) {
      CAPTURE(stage);
      CHECK(tets::find_fault(mesh) == "");
      CHECK(least_quality(mesh) >= least * (1 - 1e-6));
      least = least_quality(mesh);
      CHECK(fixed_faces(mesh) == faces);
      CHECK(volume_of_region(mesh, 0) == Approx(volume).epsilon(1e-12));
      for (std::uint32_t t = 0; t < mesh.size(); ++t) {
        if (!mesh.is_dead(t)) CHECK(std::cbrt(working.quality(t)) == Approx(quality_of(mesh, t)).epsilon(1e-5));
      }
    };
    tets::insert_points(working, 0.9, runner), check("insertion");
    tets::remove_vertices(working, 0.9, runner), check("vertex removal");
    tets::remove_edges(working, 0.9, runner), check("edge removal");
    tets::move_vertices(working, 1, runner), check("motion");
    tets::insert_points(working, 0.5, runner), check("insertion into what is left");
    tets::remove_vertices(working, 0.5, runner), check("vertex removal from what is left");
    working.finish();
    CHECK(tets::find_fault(mesh) == "");
    std::vector<bool> used(mesh.points.size());
    for (const std::uint32_t v : mesh.to_vert) used[v] = true;
    CHECK(std::find(used.begin(), used.end(), false) == used.end());
  }
}

TEST_CASE("a mesh that is far from the origin is optimised as well") {
  ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 7);
  for (Vec3& p : grid.mesh.points) p += Vec3{1e9, -3e9, 2e9};
  REQUIRE(tets::find_fault(grid.mesh).empty());
  const double least = least_quality(grid.mesh);
  tets::OptimizeOptions options;
  options.fixed_points = grid.fixed_points;
  tets::optimize(grid.mesh, options, TaskRunner(1));
  CHECK(tets::find_fault(grid.mesh) == "");
  CHECK(least_quality(grid.mesh) > least);
}

TEST_CASE("the unit of length does not matter") {
  const ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 9);
  tets::OptimizeOptions options;
  options.fixed_points = grid.fixed_points;
  TetMesh reference = grid.mesh;
  tets::optimize(reference, options, TaskRunner(1));
  for (const double unit : {0x1p-40, 0x1p40}) {
    TetMesh mesh = grid.mesh;
    for (Vec3& p : mesh.points) p *= unit;
    tets::optimize(mesh, options, TaskRunner(1));
    for (Vec3& p : mesh.points) p *= 1 / unit;
    CHECK(same(mesh, reference));
  }
}

TEST_CASE("a host that cancels gets an error and a mesh that is whole") {
  ShakenGrid grid = make_shaken_grid(4, 1, 0.5, 3);
  CancelToken token;
  token.cancel();
  const TaskRunner runner(1, Host{{}, &token});
  tets::OptimizeOptions options;
  options.fixed_points = grid.fixed_points;
  CHECK_THROWS_AS(tets::optimize(grid.mesh, options, runner), Error);
  CHECK(tets::find_fault(grid.mesh) == "");
}

TEST_CASE("higher goals leave fewer tets below them, and without rounds no point comes or goes") {
  const ShakenGrid grid = make_shaken_grid(8, 1, 0.9, 7);
  const auto optimized = [&](const QualityGoals& goals) {
    TetMesh mesh = grid.mesh;
    tets::OptimizeOptions options;
    options.fixed_points = grid.fixed_points;
    options.goals = goals;
    const tets::OptimizeReport report = tets::optimize(mesh, options, TaskRunner(1));
    std::size_t below = 0, acute = 0;
    for (std::uint32_t t = 0; t < mesh.size(); ++t) {
      below += quality_of(mesh, t) < goals.mean_ratio;
      acute += tets::smallest_dihedral(mesh, t).angle < goals.dihedral * 3.14159265358979 / 180;
    }
    CHECK(report.below_goal == below);
    CHECK(report.below_dihedral == acute);
    return std::pair(mesh, report);
  };
  const auto count_below = [](const TetMesh& mesh, double goal) {
    std::size_t count = 0;
    for (std::uint32_t t = 0; t < mesh.size(); ++t) count += quality_of(mesh, t) < goal;
    return count;
  };
  const auto [usual, usual_report] = optimized({});
  const auto [ratio, ratio_report] = optimized({15, 0.65, 2});
  CHECK(ratio_report.below_goal < count_below(usual, 0.65));
  CHECK(optimized({15, 0.65, 8}).second.below_goal <= ratio_report.below_goal);
  const auto [none, none_report] = optimized({30, 0.65, 0});
  CHECK(none_report.points_inserted + none_report.vertices_removed == 0);
  CHECK(optimized({30, 0.5, 2}).second.below_dihedral < none_report.below_dihedral);
}

TEST_CASE("dead tets of the input are dropped") {
  ShakenGrid grid = make_shaken_grid(3, 1, 0.4, 5);
  TetMesh mesh = grid.mesh;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 4; ++k) mesh.to_vert.push_back(kNone), mesh.to_neighbor.push_back(kNone);
    mesh.to_region.push_back(0);
    mesh.to_fixed.push_back(0);
  }
  tets::OptimizeOptions options;
  options.fixed_points = grid.fixed_points;
  tets::optimize(mesh, options, TaskRunner(1));
  CHECK(tets::find_fault(mesh) == "");
  for (std::uint32_t t = 0; t < mesh.size(); ++t) CHECK_FALSE(mesh.is_dead(t));
  CHECK(volume_of_region(mesh, 0) == Approx(27));
}

TEST_CASE("an empty mesh is optimal") {
  TetMesh mesh;
  CHECK_NOTHROW(tets::optimize(mesh, {}, TaskRunner(1)));
  const SizeField sizes = SizeField::uniform(1);
  tets::OptimizeOptions options;
  options.sizes = &sizes;
  CHECK_NOTHROW(tets::optimize(mesh, options, TaskRunner(1)));
}

TEST_CASE("optimising refuses options out of range") {
  const auto code_of = [](const tets::OptimizeOptions& options) {
    TetMesh mesh = make_octahedron({0, 0, 0});
    try {
      tets::optimize(mesh, options, TaskRunner(1));
    } catch (const Error& error) {
      return error.code();
    }
    return ErrorCode::Internal;
  };
  tets::OptimizeOptions many, low, high, wide, acute, backwards, endless;
  many.fixed_points = 8;
  low.goals.mean_ratio = -0.1;
  high.goals.mean_ratio = 0.91;
  wide.goals.dihedral = 61;
  acute.goals.dihedral = std::nan("");
  backwards.goals.rounds = -1;
  endless.goals.rounds = 101;
  for (const auto& options : {many, low, high, wide, acute, backwards, endless})
    CHECK(code_of(options) == ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace tetloom
