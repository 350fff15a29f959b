// Vertices of the surface on their way to the model.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/adapt/one_round.hpp"
#include "tests/adapt/uniform_metric.hpp"
#include "tests/support/mixed_mesh.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

struct Snapped {
  bool is_there = false;  // still a vertex
  Vec3 point;
  std::size_t unsnapped = 0, points = 0;
  double volume = 0;
};

/// The unit cube in 3³ cubes, whose vertex `special` of a side has its place on the model at `place`, while all others
/// are on it; sizes `h` are asked for.
Snapped snap(const Vec3& special, const Vec3& place, double h = 0.5) {
  test::BoxSpec spec{3, 3, 3, false, 1};
  spec.h = 1.0 / 3;
  const Mesh box = test::make_tet_box(spec);
  const MetricField metric = test::uniform_metric(box, h);
  const auto is_special = [&](const Vec3& x) { return distance(x, special) < 1e-9; };
  const SurfaceProjector project = [&](ModelEntity, const Vec3& x) {
    return std::optional(SurfaceSpot{is_special(x) ? place : x, {}});
  };
  Snapped snapped;
  const auto pass = [&](CavityMesh& part, Passes& passes) {
    std::uint32_t vert = kNone;
    for (std::uint32_t v = 0; v < part.mesh.points.size(); ++v)
      if (is_special(part.point(v))) vert = v;
    REQUIRE(vert != kNone);
    passes.smooth(1.1);
    snapped.unsnapped = passes.counts().unsnapped;
    snapped.is_there = part.vert_to_tet[vert] != kNone;
    snapped.point = part.point(vert);
    for (std::uint32_t v = 0; v < part.mesh.points.size(); ++v) snapped.points += part.vert_to_tet[v] != kNone;
    for (std::uint32_t tet = 0; tet < part.mesh.size(); ++tet) {
      if (part.mesh.is_dead(tet)) continue;
      const std::uint32_t* v = part.verts(tet);
      const Vec3& x = part.point(v[0]);
      snapped.volume += dot(cross(part.point(v[1]) - x, part.point(v[2]) - x), part.point(v[3]) - x) / 6;
    }
  };
  test::in_one_round(box, metric, project, 1, pass);
  return snapped;
}

}  // namespace

TEST_CASE("a vertex beside the model goes to it", "[adapt]") {
  const Vec3 place{1.0 / 3, 1.0 / 3, -0.05};
  const Snapped snapped = snap({1.0 / 3, 1.0 / 3, 0}, place);
  CHECK(snapped.is_there);
  CHECK(snapped.unsnapped == 0);
  CHECK(distance(snapped.point, place) < 1e-12);
  CHECK(snapped.volume > 1);
}

TEST_CASE("a vertex that cannot go to the model leaves the mesh", "[adapt]") {
  // All the way through the cube, and far beyond it.
  const Snapped snapped = snap({1.0 / 3, 1.0 / 3, 0}, {1.0 / 3, 1.0 / 3, 20});
  CHECK(!snapped.is_there);
  CHECK(snapped.unsnapped == 0);
  CHECK(snapped.points == 63);
  CHECK(snapped.volume == Approx(1).epsilon(1e-12));
}

TEST_CASE("a vertex that can neither go to the model nor leave is told of", "[adapt]") {
  // Without it, edges would be far too long.
  const Snapped snapped = snap({1.0 / 3, 1.0 / 3, 0}, {1.0 / 3, 1.0 / 3, 20}, 1.0 / 3);
  CHECK(snapped.is_there);
  CHECK(snapped.unsnapped == 1);
  CHECK(snapped.volume == Approx(1).epsilon(1e-12));
}

TEST_CASE("a corner of the model is snapped nowhere", "[adapt]") {
  const Snapped snapped = snap({0, 0, 0}, {1, 1, 20});
  CHECK(snapped.is_there);
  CHECK(snapped.unsnapped == 0);
  CHECK(distance(snapped.point, Vec3{}) < 1e-12);
}
