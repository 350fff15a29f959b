// Boundary recovery: shapes from harmless to impossible without new points, bad surfaces, what must stay.
#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>

#include "core/tets/find_triangles.hpp"
#include "mesher/tets/delaunay.hpp"
#include "mesher/tets/recovery.hpp"
#include "mesher/tets/small_polyhedron.hpp"
#include "tests/mesher/recovery_shapes.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::tets;
using namespace tetloom::tets::recovery_tests;

namespace {

TetMesh delaunay_of(std::span<const Vec3> points) {
  TetMesh mesh;
  mesh.points.append(points);
  std::vector<std::uint32_t> verts(points.size());
  std::iota(verts.begin(), verts.end(), 0u);
  make_delaunay(mesh, verts, TaskRunner(1));
  return mesh;
}

double volume_of(const TetMesh& mesh) {
  double sum = 0;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    const Vec3 a = mesh.point_of(t, 0);
    sum += dot(cross(mesh.point_of(t, 1) - a, mesh.point_of(t, 2) - a), mesh.point_of(t, 3) - a) / 6;
  }
  return sum;
}

std::size_t count_fixed(const TetMesh& mesh) {
  std::size_t sides = 0;
  for (const FaceCode face : mesh.faces()) sides += mesh.is_fixed(face);
  return sides;
}

// The mesh after the recovery with all that holds whatever was asked for.
struct Recovered {
  TetMesh mesh;
  RecoveryReport report;
  std::vector<FaceCode> tri_to_face;
};
Recovered recover(const Shape& shape, const RecoverOptions& options = {}, int threads = 1) {
  Recovered result{delaunay_of(shape.points), {}, {}};
  const GrowingArray<Vec3> given = result.mesh.points;
  const double volume = volume_of(result.mesh);
  const TaskRunner runner(threads);
  result.report = recover_boundary(result.mesh, shape.triangles, options, runner);
  result.tri_to_face = find_triangles(result.mesh, shape.triangles, runner);
  CHECK(find_fault(result.mesh) == "");
  CHECK(volume_of(result.mesh) == Approx(volume).epsilon(1e-12));
  CHECK(std::equal(given.begin(), given.end(), result.mesh.points.begin()));
  CHECK(result.mesh.points.size() == given.size() + result.report.new_points);
  return result;
}

void check_wholly_recovered(const Shape& shape, const Recovered& result) {
  CHECK(result.report.unrecovered.empty());
  for (const FaceCode face : result.tri_to_face) {
    REQUIRE(face.valid());
    CHECK(result.mesh.is_fixed(face));
    CHECK(result.mesh.is_fixed(result.mesh.behind(face)));
  }
  CHECK(count_fixed(result.mesh) == 2 * shape.triangles.size());
}

}  // namespace

TEST_CASE("triangles that are there are fixed on both sides and nothing else changes") {
  const Shape ball = sphere(3);
  const TetMesh before = delaunay_of(ball.points);
  const Recovered result = recover(ball);
  check_wholly_recovered(ball, result);
  CHECK(result.report.missing_triangles == 0);
  CHECK(result.mesh.to_vert == before.to_vert);
  CHECK(result.mesh.to_neighbor == before.to_neighbor);
}

TEST_CASE("the face found for a triangle is that of the tet on its front side") {
  const Shape ball = sphere(2);
  const Recovered result = recover(ball);
  for (std::size_t i = 0; i < ball.triangles.size(); ++i) {
    const auto& [a, b, c] = ball.triangles[i];
    const std::uint32_t apex = result.mesh.apex(result.tri_to_face[i]);
    CHECK(orient3d(ball.points[a], ball.points[b], ball.points[c], result.mesh.points[apex]) > 0);
  }
}

TEST_CASE("an edge through a face of two tets is recovered by a flip") {
  const Shape fin{{{0, 0, 0}, {3, 0, 0}, {1.5, 3, 0}, {1.5, 1, 3}, {1.5, 1.1, -3}}, {{0, 3, 4}}};
  const Recovered result = recover(fin);
  check_wholly_recovered(fin, result);
  CHECK(result.report.missing_triangles == 1);
  CHECK(result.report.missing_edges == 1);
  CHECK(result.report.flips == 1);
  CHECK(result.report.reconnections + result.report.new_points == 0);
}

TEST_CASE("Schoenhardt's polyhedron is recovered with a point inside") {
  const Shape prism = twisted_prism(3, -0.5);
  const Recovered result = recover(prism);
  check_wholly_recovered(prism, result);
  CHECK(result.report.new_points <= 2);
}

TEST_CASE("without new points Schoenhardt's polyhedron is reported and the mesh stays sound") {
  for (const double turn : {-0.5, 0.5}) {
    RecoverOptions options;
    options.allow_new_points = false;
    const Recovered result = recover(twisted_prism(3, turn), options);
    CHECK(result.report.new_points == 0);
    for (const auto& entry : result.report.unrecovered) {
      CHECK(entry.fault == RecoveryFault::NotRecovered);
      CHECK(norm(entry.point) < 2);
      CHECK_FALSE(result.tri_to_face[entry.triangle].valid());
    }
  }
}

TEST_CASE("random shapes are recovered wholly") {
  const int seed = GENERATE(range(0, 12));
  INFO("seed " << seed);
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  const int n = 2 + seed % 3;
  const Shape shapes[] = {spiky_ball(random, 2, 0.05),
                          thin_shell(random, 2, 0.7, 0.95),
                          thin_shell(random, 3, 0.95, 0.99),
                          cubes(random, n, 2, {1, 1, 1}, 0),
                          cubes(random, n, 4, {1, 1, 1}, 0),
                          cubes(random, n, 4, {1, 0.3, 0.05}, 0.2),
                          twisted_prism(3 + static_cast<std::uint32_t>(seed % 7), (seed % 2 == 0 ? 0.4 : -0.4) / n)};
  for (const Shape& shape : shapes) check_wholly_recovered(shape, recover(shape));
}

TEST_CASE("open surfaces with edges of any number of triangles leave a sound mesh and a true report") {
  const int seed = GENERATE(range(0, 6));
  INFO("seed " << seed);
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  for (const bool on_grid : {false, true}) {
    const Shape shape = loose_triangles(random, 15, 120, on_grid);
    const Recovered result = recover(shape);
    std::vector<std::uint32_t> absent;
    for (std::uint32_t i = 0; i < shape.triangles.size(); ++i) {
      if (!result.tri_to_face[i].valid()) absent.push_back(i);
    }
    REQUIRE(result.report.unrecovered.size() == absent.size());
    for (std::size_t i = 0; i < absent.size(); ++i) CHECK(result.report.unrecovered[i].triangle == absent[i]);
    CHECK(count_fixed(result.mesh) == 2 * (shape.triangles.size() - absent.size()));
  }
}

TEST_CASE("points inside the volume are kept") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  Shape shape = spiky_ball(random, 2, 0.2);
  for (int i = 0; i < 500; ++i) shape.points.push_back({coordinate(random), coordinate(random), coordinate(random)});
  const Recovered result = recover(shape);
  check_wholly_recovered(shape, result);
  std::vector<bool> used(result.mesh.points.size());
  for (const std::uint32_t v : result.mesh.to_vert) used[v] = true;
  CHECK(std::all_of(used.begin(), used.end(), [](bool x) { return x; }));
}

TEST_CASE("faces that were fixed before stay") {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(seed);
    const Shape inner = spiky_ball(random, 2, 0.2);
    Shape outer = spiky_ball(random, 2, 0.8), both = inner;
    for (Vec3& p : outer.points) p = 1.3 * p;
    both.append(outer);
    const std::span<const TriangleVerts> first(both.triangles.data(), inner.triangles.size());
    const std::span<const TriangleVerts> second = std::span(both.triangles).subspan(first.size());
    TetMesh mesh = delaunay_of(both.points);
    const TaskRunner runner(1);
    CHECK(recover_boundary(mesh, first, {}, runner).unrecovered.empty());
    CHECK(recover_boundary(mesh, second, {}, runner).unrecovered.empty());
    CHECK(find_fault(mesh) == "");
    for (const FaceCode face : find_triangles(mesh, both.triangles, runner)) {
      REQUIRE(face.valid());
      CHECK(mesh.is_fixed(face));
    }
  }
}

TEST_CASE("crossing triangles are reported with the place and the other triangle") {
  const Shape crossing{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1.1, 1, 1}, {1, 0.9, 1.2}},
                       {{0, 1, 2}, {3, 4, 5}}};
  const Recovered result = recover(crossing);
  REQUIRE(result.report.unrecovered.size() == 1);
  const UnrecoveredTriangle& entry = result.report.unrecovered[0];
  CHECK(entry.fault == RecoveryFault::Crossed);
  CHECK(entry.other == 1 - entry.triangle);
}

TEST_CASE("repeated, degenerate and unknown triangles and points on triangles are reported") {
  const Shape bad{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, 0}, {8, 0, 0}, {1, 1, 3}},
                  {{0, 1, 5}, {5, 0, 1}, {1, 0, 5}, {0, 1, 4}, {0, 0, 1}, {0, 1, 99}, {0, 1, 2}}};
  const Recovered result = recover(bad);
  REQUIRE(result.report.unrecovered.size() == 6);
  const RecoveryFault expected[] = {RecoveryFault::Duplicate,  RecoveryFault::Duplicate,  RecoveryFault::Degenerate,
                                    RecoveryFault::Degenerate, RecoveryFault::Degenerate, RecoveryFault::PointInside};
  for (std::uint32_t i = 0; i < 6; ++i) {
    CHECK(result.report.unrecovered[i].triangle == i + 1);
    CHECK(result.report.unrecovered[i].fault == expected[i]);
  }
  CHECK(result.report.unrecovered[0].other == 0);
  CHECK(result.report.unrecovered[5].point == bad.points[3]);
}

TEST_CASE("triangles at random, most of which cross others, end in a sound mesh") {
  RecoverOptions options;
  options.steps_of_group = options.steps_in_all = 2'000'000;
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    INFO("seed " << seed);
    std::mt19937_64 random(seed);
    Shape shape = loose_triangles(random, 16, 0, seed % 2 == 0);
    for (int i = 0; i < 30; ++i) {
      TriangleVerts t;
      for (std::uint32_t& v : t) v = static_cast<std::uint32_t>(random() % 18);  // the last two are not of the surface
      shape.triangles.push_back(t);
    }
    CHECK_FALSE(recover(shape, options).report.unrecovered.empty());
  }
}

TEST_CASE("a surface that crosses itself is asked about once, when the searches take long, and given up") {
  std::mt19937_64 random(5);
  Shape shape = loose_triangles(random, 200, 0, false);
  for (int i = 0; i < 400; ++i) {
    TriangleVerts t;
    for (std::uint32_t& v : t) v = static_cast<std::uint32_t>(random() % 200);
    shape.triangles.push_back(t);
  }
  for (const bool in_vain : {true, false}) {
    int asked = 0;
    std::uint64_t polls = 0, polls_before = 0;
    Host host;
    host.wants_stop = [&] { return ++polls == 0; };
    RecoverOptions options;
    options.steps_in_all = 20'000'000;
    options.is_in_vain = [&] {
      polls_before = polls;
      return ++asked > 0 && in_vain;
    };
    TetMesh mesh = delaunay_of(shape.points);
    CHECK_FALSE(recover_boundary(mesh, shape.triangles, options, TaskRunner(1, host)).unrecovered.empty());
    CHECK(find_fault(mesh) == "");
    CHECK(asked == 1);
    const std::uint64_t searches_at_most = 2000;  // one look per edge and triangle that is passed over
    if (in_vain) CHECK(polls - polls_before < searches_at_most);
    if (!in_vain) CHECK(polls - polls_before > searches_at_most);
  }
}

TEST_CASE("the recovery does not depend on threads") {
  std::mt19937_64 random(3);
  const Shape shape = cubes(random, 4, 3, {1, 1, 0.1}, 0.1);
  const Recovered one = recover(shape), four = recover(shape, {}, 4);
  CHECK(one.mesh.to_vert == four.mesh.to_vert);
  CHECK(one.mesh.points == four.mesh.points);
  CHECK(one.tri_to_face == four.tri_to_face);
}

TEST_CASE("a small polyhedron is filled between its points, or said to have no such tets") {
  const auto fill = [](const Shape& shape) {
    SmallPolyhedron polyhedron{shape.points, {}, {}};
    for (const auto& [a, b, c] : shape.triangles)  // from inside
      polyhedron.faces.push_back(
          {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(c), static_cast<std::uint8_t>(b)});
    return fill_small_polyhedron(polyhedron, 1'000'000);
  };
  int filled = 0, impossible = 0;
  for (const double turn : {0.5, -0.5}) {
    const SmallFilling filling = fill(twisted_prism(3, turn));
    filled += filling.outcome == SmallFilling::Found;
    impossible += filling.outcome == SmallFilling::Impossible;
  }
  CHECK(filled == 1);
  CHECK(impossible == 1);
}

TEST_CASE("a recovery with new points looks often whether to go on, and stopped at any time leaves a sound mesh") {
  const Shape prism = twisted_prism(3, -0.5);
  const TetMesh before = delaunay_of(prism.points);
  const auto polls_of = [&](std::uint64_t last) {
    std::uint64_t polls = 0;
    Host host;
    host.wants_stop = [&] { return ++polls == last; };
    TetMesh mesh = before;
    bool cancelled = false;
    try {
      recover_boundary(mesh, prism.triangles, {}, TaskRunner(1, host));
    } catch (const Error& error) {
      cancelled = error.code() == ErrorCode::Cancelled;
    }
    CHECK(cancelled == (polls == last));
    CHECK(find_fault(mesh) == "");
    return polls;
  };
  const std::uint64_t polls = polls_of(0);  // never stopped
  // One per missing edge, triangle and group, with seconds between them, would be 28.
  CHECK(polls > 50);
  for (std::uint64_t last = 1; last <= polls; ++last) polls_of(last);
}
