#include "tetloom/metric.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/adapt/box_mesh.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/support/block_loops.hpp"
#include "tests/support/error_of.hpp"

using namespace tetloom;
using namespace tetloom::adapt;
using test::error_of;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double ratio_along(const MetricField& metric, std::size_t vert, const Vec3& e) {
  return 1 / std::sqrt(dot(metric.at(vert), e) / norm2(e));
}

MetricField random_metric(std::size_t count, double aspect, unsigned seed) {
  RandomTensors random(seed);
  MetricField metric;
  for (std::size_t v = 0; v < count; ++v)
    metric.logs.push_back(tetloom::adapt::log(compose(random.metric(0.01, aspect))));
  return metric;
}

}  // namespace

TEST_CASE("a metric is made from sizes, tensors and matrices", "[metric_field]") {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}};
  const MetricField sizes = metric_from_field({"h", 1, {0.5, 2}}, TensorOrder::Vtk, points);
  CHECK(largest_entry(sizes.at(0) - isotropic(0.5)) < 1e-14);
  CHECK(largest_entry(sizes.at(1) - isotropic(2)) < 1e-14);
  const Tensor m{4, 0.5, 5, 0.25, 1, 6};
  const auto check = [&](const MetricField& metric) {
    REQUIRE(metric.size() == 2);
    CHECK(largest_entry(metric.at(0) - m) < 1e-13);
    CHECK(largest_entry(metric.at(1) - isotropic(1)) < 1e-13);
  };
  check(metric_from_field({"m", 6, {4, 0.5, 5, 0.25, 1, 6, 1, 0, 1, 0, 0, 1}}, TensorOrder::Medit, points));
  check(metric_from_field({"m", 6, {4, 5, 6, 0.5, 1, 0.25, 1, 1, 1, 0, 0, 0}}, TensorOrder::Vtk, points));
  check(metric_from_field({"m", 9, {4, 0.5, 0.25, 0.5, 5, 1, 0.25, 1, 6, 1, 0, 0, 0, 1, 0, 0, 0, 1}}, TensorOrder::Vtk,
                          points));
  check(metric_from_function([&](const Vec3& p) { return p.x == 0 ? m : isotropic(1); }, points));
  for (const TensorOrder order : {TensorOrder::Medit, TensorOrder::Vtk})
    check(metric_from_field(field_of_metric(metric_from_tensors(std::vector{m, isotropic(1)}, points), order), order,
                            points));
}

TEST_CASE("what is no metric is refused with the vertex and its place", "[metric_field]") {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 2, 3}};
  const auto refused = [&](const MeshField& field, const char* reason) {
    const Diagnostic error = error_of([&] { static_cast<void>(metric_from_field(field, TensorOrder::Medit, points)); });
    CHECK(error.code == ErrorCode::InputUnsuitable);
    CHECK_THAT(error.message, Catch::Contains("vertex 2") && Catch::Contains(reason));
    CHECK(error.elements == std::vector<std::uint64_t>{1});
    CHECK(error.point == Vec3{1, 2, 3});
  };
  refused({"h", 1, {1, 0}}, "not positive");
  refused({"h", 1, {1, -1}}, "not positive");
  refused({"h", 1, {1, kNan}}, "no finite number");
  refused({"h", 1, {1, HUGE_VAL}}, "no finite number");
  refused({"m", 6, {1, 0, 1, 0, 0, 1, 1, 2, 1, 0, 0, 1}}, "not positive definite");
  refused({"m", 6, {1, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0}}, "not positive definite");
  refused({"m", 6, {1, 0, 1, 0, 0, 1, 1, 0, 1, 0, kNan, 1}}, "no finite numbers");
  refused({"m", 9, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0.1, 0, 0, 1, 0, 0, 0, 1}}, "not symmetric");
  refused({"m", 9, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, kNan, 0, 1, 0, kNan, 0, 1}}, "no finite numbers");
  const auto code_of = [&](const MeshField& field) {
    return error_of([&] { static_cast<void>(metric_from_field(field, TensorOrder::Medit, points)); }).code;
  };
  CHECK(code_of({"h", 1, {1}}) == ErrorCode::InvalidArgument);
  CHECK(code_of({"m", 6, {1, 0, 1, 0, 0, 1}}) == ErrorCode::InvalidArgument);
  CHECK(code_of({"m", 9, {}}) == ErrorCode::InvalidArgument);
  CHECK(code_of({"v", 3, {1, 0, 1, 0, 0, 1}}) == ErrorCode::InputUnsuitable);
}

TEST_CASE("the first vertex that is no good is named, whoever carries out the loop", "[metric_field]") {
  const std::vector<Vec3> points(20000);
  std::vector<double> sizes(20000, 1);
  sizes[17000] = sizes[9000] = sizes[5001] = 0;
  const auto diagnostic = error_of([&] { static_cast<void>(metric_from_sizes(sizes, points, test::BackwardsLoop())); });
  CHECK(diagnostic.elements == std::vector<std::uint64_t>{5001});
}

TEST_CASE("bounds limit sizes and aspect ratios", "[metric_field]") {
  const unsigned seed = 4;
  CAPTURE(seed);
  MetricField metric = random_metric(500, 1e4, seed);
  const MetricField before = metric;
  const MetricBounds bounds{0.02, 3, 50};
  apply_bounds(metric, bounds);
  for (std::size_t v = 0; v < metric.size(); ++v) {
    const EigenSystem e = eigen(metric.logs[v]);
    const double smallest = std::exp(-0.5 * e.values[2]), largest = std::exp(-0.5 * e.values[0]);
    CHECK(smallest >= 0.02 * (1 - 1e-12));
    CHECK(largest <= 3 * (1 + 1e-12));
    CHECK(largest <= 50 * smallest * (1 + 1e-12));
  }
  const MetricField once = metric;
  apply_bounds(metric, {1e-6, 1e6, 1e9});
  CHECK(metric.logs == once.logs);
  CHECK(once.logs != before.logs);
  for (const MetricBounds& bad : {MetricBounds{2, 1, 10}, MetricBounds{-1, 1, 10}, MetricBounds{0, 1, 0.5},
                                  MetricBounds{0, 0, 2}, MetricBounds{kNan, 1, 2}, MetricBounds{0, 1, kNan}})
    CHECK(error_of([&] { apply_bounds(metric, bad); }).code == ErrorCode::InvalidArgument);
}

TEST_CASE("intersecting fields takes the smaller sizes", "[metric_field]") {
  MetricField a = random_metric(300, 100, 5);
  const MetricField b = random_metric(300, 100, 6), first = a;
  intersect(a, b);
  RandomTensors random(7);
  for (std::size_t v = 0; v < a.size(); ++v) {
    const Vec3 e = random.vector();
    CHECK(ratio_along(a, v, e) <= std::min(ratio_along(first, v, e), ratio_along(b, v, e)) * (1 + 1e-6));
  }
  MetricField same = first;
  intersect(same, first);
  CHECK(same.logs == first.logs);
}

TEST_CASE("the complexity counts unit cubes", "[metric_field]") {
  const BoxMesh mesh = make_box_mesh(4, 0.2);
  const std::vector<double> sizes(mesh.points.size(), 0.1);
  MetricField metric = metric_from_sizes(sizes, mesh.points);
  CHECK(complexity(metric, mesh.view()) == Approx(1000).epsilon(1e-12));
  Mesh whole;
  whole.points = mesh.points;
  whole.tet_to_vert = mesh.tets;
  CHECK(complexity(metric, tets_of(whole)) == complexity(metric, mesh.view()));
  CHECK(expected_tets(1000) == Approx(8485).epsilon(1e-3));
  CHECK(scale_to_complexity(metric, mesh.view(), 8000) == Approx(8000).epsilon(1e-9));
  CHECK(largest_entry(metric.at(0) - isotropic(0.05)) < 1e-8);
}

TEST_CASE("a metric is scaled to a complexity within bounds", "[metric_field]") {
  const BoxMesh mesh = make_box_mesh(6, 0.2);
  MetricField metric = random_metric(mesh.points.size(), 1e3, 8);
  const MetricBounds bounds{0.01, 0.5, 20};
  CHECK(scale_to_complexity(metric, mesh.view(), 5000, bounds) == Approx(5000).epsilon(1e-6));
  CHECK(complexity(metric, mesh.view()) == Approx(5000).epsilon(1e-6));
  for (std::size_t v = 0; v < metric.size(); ++v) {
    const EigenSystem e = eigen(metric.logs[v]);
    CHECK(std::exp(-0.5 * e.values[2]) >= 0.01 * (1 - 1e-12));
    CHECK(std::exp(-0.5 * e.values[0]) <= 0.5 * (1 + 1e-12));
  }
  // Out of reach of the bounds: as near as they let it come.
  CHECK(scale_to_complexity(metric, mesh.view(), 1e12, bounds) == Approx(1e6).epsilon(1e-9));
  CHECK(scale_to_complexity(metric, mesh.view(), 1e-3, bounds) == Approx(8).epsilon(1e-9));
}

TEST_CASE("gradation lets sizes grow from a small one as asked", "[metric_field]") {
  const BoxMesh mesh = make_box_mesh(10);
  const VertexGraph graph(mesh.view());
  std::vector<double> sizes(mesh.points.size(), 10);
  sizes[0] = 0.01;
  MetricField metric = metric_from_sizes(sizes, mesh.points);
  const GradationResult result = limit_gradation(metric, mesh.points, graph, 1.3);
  CHECK(result.changed > 1000);
  CHECK(metric.logs[0] == log_isotropic(0.01));
  // Isotropic sizes grow by log(1.3) times the distance along edges of the mesh.
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3 p = mesh.points[v];
    const double most = 0.01 + std::log(1.3) * (p.x + p.y + p.z), h = std::exp(-metric.logs[v].xx / 2);
    CHECK(h <= most * 1.001);
    CHECK(h >= 0.01 + std::log(1.3) * norm(p) * 0.999);
  }
  MetricField again = metric;
  CHECK(limit_gradation(again, mesh.points, graph, 1.3).changed == 0);
  CHECK(again.logs == metric.logs);
}

TEST_CASE("gradation of any metric ends, keeps to its law and does not depend on the loop", "[metric_field]") {
  const BoxMesh mesh = make_box_mesh(9, 0.2);
  const VertexGraph graph(mesh.view(), test::BackwardsLoop());
  for (const double aspect : {10., 1e3, 1e5}) {
    CAPTURE(aspect);
    const MetricField before = random_metric(mesh.points.size(), aspect, 11);
    MetricField metric = before, other = before;
    const GradationResult result = limit_gradation(metric, mesh.points, graph, 1.2);
    CHECK(result.rounds < 200);
    CHECK(limit_gradation(other, mesh.points, graph, 1.2, test::ThreadsLoop(3)).rounds == result.rounds);
    CHECK(other.logs == metric.logs);
    RandomTensors random(12);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      const Vec3 e = random.vector();
      CHECK(ratio_along(metric, v, e) <= ratio_along(before, v, e) * (1 + 1e-6));
      for (const std::uint32_t w : graph.neighbors(v)) {
        // The least growth that the law allows in any direction.
        const Vec3 edge = mesh.points[w] - mesh.points[v];
        const double l = std::sqrt(dot(metric.at(v), edge)) * std::log(1.2);
        const double longest = 1 + std::exp(0.5 * eigen(metric.logs[v]).values[2]) * norm(edge) * std::log(1.2);
        CHECK(ratio_along(metric, w, e) <=
              ratio_along(metric, v, e) * std::pow(1 + l, 0.875) * std::pow(longest, 0.125) * 1.002);
      }
    }
  }
  MetricField metric = random_metric(mesh.points.size(), 10, 1);
  for (const double bad : {1., 0.5, kNan, HUGE_VAL})
    CHECK(error_of([&] { limit_gradation(metric, mesh.points, graph, bad); }).code == ErrorCode::InvalidArgument);
}

TEST_CASE("neighbours are those of the edges", "[metric_field]") {
  const BoxMesh mesh = make_box_mesh(3);
  const VertexGraph graph(mesh.view());
  CHECK(graph.size() == mesh.points.size());
  std::vector<std::vector<std::uint32_t>> expected(mesh.points.size());
  for (const TetVerts& tet : mesh.tets)
    for (const std::uint32_t a : tet)
      for (const std::uint32_t b : tet)
        if (a != b && std::find(expected[a].begin(), expected[a].end(), b) == expected[a].end())
          expected[a].push_back(b);
  for (std::size_t v = 0; v < graph.size(); ++v) {
    std::sort(expected[v].begin(), expected[v].end());
    CHECK(std::equal(expected[v].begin(), expected[v].end(), graph.neighbors(v).begin(), graph.neighbors(v).end()));
  }
}
