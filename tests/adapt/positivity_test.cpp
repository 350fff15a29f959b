// What adaptation makes is positive by the exact predicate, where floating point alone would be wrong.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>

#include "adapt/kernel/ring_in_metric.hpp"
#include "adapt/result_check.hpp"
#include "adapt/touching_edges.hpp"
#include "core/predicates/predicates.hpp"
#include "tests/adapt/box_mesh.hpp"
#include "tests/adapt/one_round.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/adapt/uniform_metric.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/mixed_mesh.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

using Tet = std::array<std::uint32_t, 4>;

/// Turned and small, so that differences of coordinates are rounded.
Mesh turned_box() {
  Mesh box = test::make_tet_box(2, 2, 2, 1);
  for (Vec3& x : box.points)
    x = 0.1 * Vec3{0.8 * x.x - 0.6 * x.y - 0.31, 0.6 * x.x + 0.8 * x.y + 0.3 * x.z - 0.77, x.z - 0.4 * x.x - 0.53};
  return box;
}

/// Visits the only part of a mesh.
void in_one_part(const Mesh& mesh, const std::function<void(CavityMesh&)>& visit) {
  const MetricField metric = test::uniform_metric(mesh, 0.1);
  test::in_one_round(mesh, metric, {}, 1, [&](CavityMesh& part, Passes&) {
    const std::vector<Vec3> points(part.mesh.points.begin(), part.mesh.points.end());
    visit(part);
    std::copy(points.begin(), points.end(), part.mesh.points.begin());
  });
}

/// In the plane of three points, but for rounding.
class PlanePoints {
 public:
  Vec3 inside(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double s = share(), t = share();
    return a + s * (b - a) + t * (c - a);
  }

 private:
  double share() { return 0.1 + 0.35 * static_cast<double>(random_()) / 4294967296.0; }
  std::mt19937 random_{7};
};

bool is_positive(const CavityMesh& part, const Tet& v) {
  return orient3d(part.point(v[0]), part.point(v[1]), part.point(v[2]), part.point(v[3])) > 0;
}

std::uint32_t vertex_inside(const CavityMesh& part) {
  std::uint32_t v = 0;
  while (part.dim_of(v) < 3) ++v;
  return v;
}

}  // namespace

TEST_CASE("a quality above 0 is that of a positive tet", "[adapt]") {
  in_one_part(turned_box(), [](CavityMesh& part) {
    PlanePoints plane;
    int positive = 0, others = 0;
    for (std::uint32_t i = 0; i < 5000; ++i) {
      const std::uint32_t a = 1 + i % 8, b = 9 + i % 9, c = 18 + i % 7;
      part.mesh.points[0] = plane.inside(part.point(a), part.point(b), part.point(c));
      const bool is = is_positive(part, {a, b, c, 0});
      (is ? positive : others) += 1;
      if (part.quality_of(a, b, c, 0) > 0 && !is) FAIL_CHECK("not positive");
    }
    CHECK(positive > 100);
    CHECK(others > 100);
  });
}

TEST_CASE("an operation that is not refused makes positive tets", "[adapt]") {
  in_one_part(turned_box(), [](CavityMesh& part) {
    const std::uint32_t v = vertex_inside(part);
    const Vec3 middle = part.point(v);
    PlanePoints plane;
    Cavity ball;
    REQUIRE(part.collect(std::span(&v, 1), part.vert_to_tet[v], ball));
    MadeQualities made;
    int accepted = 0, refused = 0;
    for (int i = 0; i < 200; ++i) {
      for (std::size_t n = 0; n < ball.tets.size(); ++n) {
        // Into the plane of an outer face.
        part.mesh.points[v] = middle;
        const std::uint32_t* verts = part.verts(ball.tets[n]);
        const auto& [a, b, c] = tets::kFaceVerts[ball.corners[n][0]];
        part.mesh.points[v] = plane.inside(part.point(verts[a]), part.point(verts[b]), part.point(verts[c]));
        bool positive = true;
        for (const std::uint32_t tet : ball.tets) {
          Tet around;
          std::copy_n(part.verts(tet), 4, around.begin());
          positive = positive && is_positive(part, around);
        }
        for (const bool at_once : {false, true}) {
          const double least = at_once ? part.evaluate_all(ball, v, 0, made) : part.evaluate(ball, v, 0, made);
          if (least > 0 && !positive) FAIL_CHECK("not positive");
        }
        (positive ? accepted : refused) += 1;
      }
    }
    CHECK(accepted > 20);
    CHECK(refused > 20);
  });
}

TEST_CASE("a triangulation of a ring that is not refused makes positive tets", "[adapt]") {
  in_one_part(turned_box(), [](CavityMesh& part) {
    PlanePoints plane;
    int found = 0;
    for (std::uint32_t tet = 0; tet < part.mesh.size(); ++tet) {
      for (const auto& [i, j] : tets::kEdgeVerts) {
        const std::array<std::uint32_t, 2> edge{part.verts(tet)[i], part.verts(tet)[j]};
        Cavity shell;
        tets::EdgeRing ring;
        if (!part.collect(edge, tet, shell) || !shell.surface.empty() || !part.find_ring(shell, ring)) continue;
        for (int k = 0; k < 50; ++k) {
          const Vec3 a = part.point(ring.a);
          part.mesh.points[ring.a] =
              plane.inside(part.point(ring.verts[0]), part.point(ring.verts[1]), part.point(ring.verts[2]));
          const bool positive = is_positive(part, {ring.verts[0], ring.verts[2], ring.verts[1], ring.a}) &&
                                is_positive(part, {ring.verts[0], ring.verts[1], ring.verts[2], ring.b});
          if (RingInMetric(part, ring).worse_over(0, 1, 2) > 0 && !positive) FAIL_CHECK("not positive");
          found += positive;
          part.mesh.points[ring.a] = a;
        }
      }
    }
    CHECK(found > 20);
  });
}

TEST_CASE("the bound of a metric proves that tets are positive", "[adapt]") {
  RandomTensors random(11);
  std::mt19937 bits(3);
  int proven = 0, flat = 0;
  for (int i = 0; i < 20000; ++i) {
    const VertexMetric metric = [&] {
      const Tensor tensor = compose(random.metric(1, std::pow(10.0, random.uniform(0, 4))));
      return VertexMetric{tensor, det(tensor)};
    }();
    const Vec3 away = random.uniform(0, 10) * random.vector();
    const Vec3 a = away + random.vector(), b = away + random.vector(), c = away + random.vector();
    const Vec3 above = std::pow(10.0, random.uniform(-18, -3)) * random.vector();
    const Vec3 d = a + 0.3 * (b - a) + 0.4 * (c - a) + above;
    const double quality = cubed_mean_ratio(b - a, c - a, d - a, metric);
    const bool positive = orient3d(a, b, c, d) > 0;
    if (!positive) ++flat;
    if (!(quality > surely_positive_quality(metric))) continue;
    ++proven;
    if (!positive) FAIL_CHECK("not positive");
  }
  CHECK(proven > 200);
  CHECK(flat > 2000);
  // What makes the bound worth having: it is far below qualities that are asked for.
  CHECK(surely_positive_quality({isotropic(0.1), det(isotropic(0.1))}) < 1e-8);
  for (const double aspect : {1e2, 1e3, 1e4}) {
    CHECK(surely_positive_quality({diagonal(1, 1, aspect * aspect), aspect * aspect}) < 1e-5);
    CHECK(surely_positive_quality({diagonal(1, aspect * aspect, aspect * aspect), std::pow(aspect, 4)}) < 1e-5);
  }
  CHECK(std::isinf(surely_positive_quality({diagonal(1, 1, 1e24), 1e24})));
}

TEST_CASE("edges at which bodies touch are split only where tets keep their sides, exactly", "[adapt]") {
  // Two flat tets that have an edge in common, and nothing else.
  PlanePoints plane;
  RandomTensors random(5);
  int split_count = 0, kept_count = 0;
  for (int i = 0; i < 400; ++i) {
    Mesh mesh;
    const Vec3 away{std::sqrt(2.0), std::sqrt(3.0), std::sqrt(5.0)};
    for (int n = 0; n < 2; ++n) mesh.points.push_back(away + random.vector());
    for (int n = 0; n < 2; ++n) {
      mesh.points.push_back(away + random.vector());
      mesh.points.push_back(plane.inside(mesh.points[0], mesh.points[1], mesh.points.back()));
    }
    mesh.tet_to_vert = {{0, 1, 2, 3}, {0, 1, 4, 5}}, mesh.tet_to_entity = {0, 0};
    int sides[2];
    for (std::size_t t = 0; t < 2; ++t) {
      const TetVerts& v = mesh.tet_to_vert[t];
      sides[t] = orient3d(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
      for (std::size_t k = 0; k < 4; ++k) {
        mesh.tri_to_vert.push_back({v[k == 0], v[k <= 1 ? 2 : 1], v[k <= 2 ? 3 : 2]});
        mesh.tri_to_entity.push_back(static_cast<std::uint32_t>(mesh.tri_to_entity.size()));
      }
    }
    if (sides[0] == 0 || sides[1] == 0) continue;
    const MetricField metric = metric_from_sizes(std::vector<double>(6, 0.2), mesh.points);
    const auto split = split_touching_edges(mesh, metric, {}, nullptr, 1000);
    (split ? split_count : kept_count) += 1;
    if (!split) continue;
    // Tets follow each other's regions: those of the first one have its third vertex.
    for (const TetVerts& v : split->mesh.tet_to_vert) {
      const bool first = std::find(v.begin(), v.end(), 2u) != v.end();
      const auto& x = split->mesh.points;
      if (orient3d(x[v[0]], x[v[1]], x[v[2]], x[v[3]]) != sides[first ? 0 : 1]) FAIL_CHECK("turned over");
    }
  }
  CHECK(split_count > 5);
  CHECK(kept_count > 5);
}

TEST_CASE("a result with a flat or inverted tet is an error with its place", "[adapt]") {
  Mesh mesh = test::make_tet_box(2, 2, 2);
  check_positive(tets_of(mesh), serial_loop());
  std::swap(mesh.tet_to_vert[7][0], mesh.tet_to_vert[7][1]);
  const Diagnostic error = test::error_of([&] { check_positive(tets_of(mesh), serial_loop()); });
  CHECK(error.code == ErrorCode::Internal);
  CHECK(error.elements == std::vector<std::uint64_t>{7});
  CHECK(error.point);
}
