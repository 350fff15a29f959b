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

template <class Function>
std::vector<double> values_of(const BoxMesh& mesh, const Function& f) {
  std::vector<double> values;
  for (const Vec3& p : mesh.points) values.push_back(f(p));
  return values;
}

std::vector<Tensor> hessians_of(const BoxMesh& mesh, const std::vector<double>& values) {
  return recover_hessian(values, mesh.view(), VertexGraph(mesh.view()));
}

}  // namespace

TEST_CASE("the Hessian of a quadratic field is exact, at the boundary as well", "[hessian]") {
  const unsigned seed = 3;
  CAPTURE(seed);
  RandomTensors random(seed);
  for (const double stretch : {1., 1e-3}) {
    BoxMesh mesh = make_box_mesh(5, 0.2);
    const std::array<Vec3, 3> basis = random.basis();
    for (Vec3& p : mesh.points) p = p.x * basis[0] + p.y * basis[1] + stretch * p.z * basis[2] + Vec3{7, -3, 2};
    const Tensor h = random.tensor();
    const Vec3 g = random.vector();
    const auto hessians =
        hessians_of(mesh, values_of(mesh, [&](const Vec3& p) { return 5 + dot(g, p) + dot(h, p) / 2; }));
    double error = 0;
    for (const Tensor& each : hessians) error = std::max(error, largest_entry(each - h));
    CAPTURE(stretch);
    CHECK(error < 1e-10 / (stretch * stretch));
  }
}

TEST_CASE("the Hessian of a smooth field converges", "[hessian]") {
  const auto f = [](const Vec3& p) { return std::sin(2 * p.x + p.y) * std::exp(p.z); };
  const auto error_on = [&](int n) {
    const BoxMesh mesh = make_box_mesh(n, 0.2);
    const auto hessians = hessians_of(mesh, values_of(mesh, f));
    double error = 0;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      const Vec3 p = mesh.points[v];
      const double s = f(p), c = std::cos(2 * p.x + p.y) * std::exp(p.z);
      error = std::max(error, largest_entry(hessians[v] - Tensor{-4 * s, -2 * s, -s, 2 * c, c, s}));
    }
    return error;
  };
  const double coarse = error_on(8), fine = error_on(16);
  CHECK(fine < 0.6 * coarse);
  CHECK(fine < 2.5);  // of 11
}

TEST_CASE("a second derivative that the mesh does not determine is small", "[hessian]") {
  BoxMesh mesh = make_box_mesh(6, 0, 1, [](const Vec3& p) { return p.z < 1.0 / 6; });  // one layer
  const auto hessians = hessians_of(mesh, values_of(mesh, [](const Vec3& p) { return p.x * p.x + p.z * p.z; }));
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const bool used = mesh.points[v].z < 0.2;
    CHECK(largest_entry(hessians[v] - (used ? diagonal(2, 0, 0) : Tensor{})) < 1e-2);
  }
}

TEST_CASE("a single tetrahedron has a Hessian of zero", "[hessian]") {
  const BoxMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  for (const Tensor& h : hessians_of(mesh, {1, 2, 3, 5})) CHECK(largest_entry(h) < 1e-12);
}

TEST_CASE("a metric from a solution has the complexity asked for and follows a layer", "[hessian]") {
  const BoxMesh mesh = make_box_mesh(14, 0.2);
  const auto values = values_of(mesh, [](const Vec3& p) { return std::tanh(8 * (p.x - 0.5)); });
  HessianOptions options;
  options.complexity = 3000;
  const HessianMetric plain = metric_from_solution(values, mesh.view(), options);
  CHECK(plain.complexity == Approx(3000).epsilon(1e-6));
  CHECK(complexity(plain.metric, mesh.view()) == Approx(3000).epsilon(1e-6));
  options.bounds = {0.005, 0.4, 30};
  options.gradation = 1.4;
  const HessianMetric graded = metric_from_solution(values, mesh.view(), options);
  CHECK(graded.complexity == Approx(3000).epsilon(0.011));
  double finest = HUGE_VAL;
  std::size_t at = 0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const EigenSystem e = eigen(graded.metric.logs[v]);
    const double h = std::exp(-0.5 * e.values[2]);
    CHECK(h >= 0.005 * (1 - 1e-9));
    CHECK(std::exp(-0.5 * e.values[0]) <= 0.4 * (1 + 1e-9));
    if (h < finest) finest = h, at = v;
  }
  CHECK(std::abs(mesh.points[at].x - 0.5) < 0.2);
  const EigenSystem e = eigen(graded.metric.logs[at]);
  CHECK(std::abs(e.vectors[2].x) > 0.98);  // the layer is thin along x
  CHECK(e.values[2] - e.values[1] > 2);

  const HessianMetric other = metric_from_solution(values, mesh.view(), options, test::ThreadsLoop(3));
  CHECK(other.metric.logs == graded.metric.logs);
}

TEST_CASE("a stronger norm puts more elements where curvature is largest", "[hessian]") {
  const BoxMesh mesh = make_box_mesh(12);
  // A strong bump beside a weak one.
  const auto bump = [](const Vec3& p, double x) { return std::exp(-40 * norm2(p - Vec3{x, 0.5, 0.5})); };
  const auto values = values_of(mesh, [&](const Vec3& p) { return bump(p, 0.25) + 0.05 * bump(p, 0.75); });
  const auto ratio_for = [&](double p) {
    HessianOptions options;
    options.complexity = 1000;
    options.norm = p;
    const MetricField metric = metric_from_solution(values, mesh.view(), options).metric;
    const std::size_t strong = (3 * 13 + 6) * 13 + 6, weak = (9 * 13 + 6) * 13 + 6;
    return trace(metric.logs[strong]) - trace(metric.logs[weak]);
  };
  CHECK(ratio_for(1) < ratio_for(2));
  CHECK(ratio_for(2) < ratio_for(8));
  CHECK(ratio_for(8) < ratio_for(HUGE_VAL));
}

TEST_CASE("fields and options that give no metric are refused", "[hessian]") {
  const BoxMesh mesh = make_box_mesh(4);
  auto values = values_of(mesh, [](const Vec3& p) { return p.x * p.x; });
  HessianOptions options;
  options.complexity = 100;
  const auto error_with = [&](const HessianOptions& with) {
    return error_of([&] { static_cast<void>(metric_from_solution(values, mesh.view(), with)); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {0., -1., nan, HUGE_VAL}) {
    HessianOptions with = options;
    with.complexity = bad;
    CHECK(error_with(with).code == ErrorCode::InvalidArgument);
  }
  for (const double bad : {0.5, nan}) {
    HessianOptions with = options;
    with.norm = bad;
    CHECK(error_with(with).code == ErrorCode::InvalidArgument);
  }
  HessianOptions with = options;
  with.gradation = 0.9;
  CHECK(error_with(with).code == ErrorCode::InvalidArgument);
  with = options;
  with.bounds.h_min = -1;
  CHECK(error_with(with).code == ErrorCode::InvalidArgument);
  values.pop_back();
  CHECK(error_with(options).code == ErrorCode::InvalidArgument);
  values = values_of(mesh, [](const Vec3& p) { return 1e6 + p.x + 3 * p.y; });
  CHECK(error_with(options).code == ErrorCode::InputUnsuitable);
  values.assign(values.size(), 4);
  CHECK(error_with(options).code == ErrorCode::InputUnsuitable);
  values[7] = nan;
  const Diagnostic error = error_with(options);
  CHECK(error.code == ErrorCode::InputUnsuitable);
  CHECK_THAT(error.message, Catch::Contains("vertex 8"));
  CHECK(error.point == mesh.points[7]);
}
