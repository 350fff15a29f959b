// Metrics that turn faster than elements can.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "tests/adapt/box_mesh.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/support/block_loops.hpp"
#include "tetloom/metric.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

using Metric = std::function<Tensor(const Vec3&)>;

double inverse_square(double h) { return 1 / (h * h); }

/// Sizes h · (aspect, sqrt(aspect), 1), which turn by `rate` radians per unit of length on the way along x, about z.
Metric turning_metric(double h, double aspect, double rate) {
  return [=](const Vec3& x) {
    const double angle = rate * x.x, c = std::cos(angle), s = std::sin(angle);
    return outer(Vec3{c, s, 0}, inverse_square(h * aspect)) + outer(Vec3{-s, c, 0}, inverse_square(h)) +
           diagonal(0, 0, inverse_square(h * std::sqrt(aspect)));
  };
}

MetricField field_of(const Metric& metric, const BoxMesh& mesh) { return metric_from_function(metric, mesh.points); }

void check_left_alone(const Metric& metric, int n) {
  const BoxMesh mesh = make_box_mesh(n, 0.2);
  const MetricField given = field_of(metric, mesh);
  MetricField field = given;
  CHECK(!limit_turning(field, mesh.view()).turns);
  CHECK(field.logs == given.logs);
}

}  // namespace

TEST_CASE("metrics that elements can follow stay as they are, bit by bit", "[turning]") {
  const double share = GENERATE(0.5, 1.0);
  CAPTURE(share);
  for (const int n : {4, 10}) {
    // Sizes alone change.
    check_left_alone([](const Vec3& x) { return isotropic(x.x > 0.5 ? 0.2 : 0.001); }, n);
    check_left_alone(
        [](const Vec3& x) { return diagonal(100, 100, inverse_square(0.0001 + 0.2 * std::abs(x.z - 0.5))); }, n);
    check_left_alone([](const Vec3& x) { return diagonal(x.x > 0.3 ? 1 : 1e8, 100, x.y > 0.3 ? 1e8 : 1); }, n);
    // The step along turns by less than the aspect ratio allows: rate · (h · aspect) · aspect = share.
    for (const double aspect : {10.0, 100.0, 1000.0})
      check_left_alone(turning_metric(share * inverse_square(aspect) / 1.0, aspect, 1), n);
    // A stack that is twisted: the small size is that of the axis.
    check_left_alone(
        [](const Vec3& x) {
          const double c = std::cos(3 * x.z), s = std::sin(3 * x.z);
          return outer(Vec3{c, s, 0}, inverse_square(0.3)) + outer(Vec3{-s, c, 0}, inverse_square(0.03)) +
                 diagonal(0, 0, inverse_square(0.001));
        },
        n);
  }
}

TEST_CASE("a metric that turns too fast has its large sizes limited, however fine the mesh", "[turning]") {
  const double aspect = GENERATE(1e2, 1e3, 1e4), h = 0.001, rate = 2;
  for (const int n : {5, 10}) {
    CAPTURE(aspect, n);
    const BoxMesh mesh = make_box_mesh(n, 0.2);
    MetricField field = field_of(turning_metric(h, aspect, rate), mesh);
    const TurningResult result = limit_turning(field, mesh.view());
    CHECK(result.turns);
    CHECK(result.followed > 1.5 * result.asked);
    CHECK(result.followed <= 4.4 * result.asked);
    for (std::size_t v = 0; v < field.size(); ++v) {
      const double c = std::abs(std::cos(rate * mesh.points[v].x));
      if (c < 0.5) continue;  // what is along hardly turns on its way there
      const EigenSystem now = eigen(field.logs[v]);
      const double small = std::exp(-0.5 * now.values[2]);
      CHECK(small > 0.999 * h);
      for (std::size_t i = 0; i < 2; ++i)
        if (std::abs(now.vectors[i].z) < 0.1)
          CHECK(std::exp(-0.5 * now.values[i]) < 1.3 * std::sqrt(small / (rate * c)));
    }
    MetricField again = field;
    CHECK(!limit_turning(again, mesh.view()).turns);
    CHECK(again.logs == field.logs);
  }
}

TEST_CASE("where no size has to become larger, none does", "[turning]") {
  const BoxMesh mesh = make_box_mesh(6, 0.2);
  const MetricField given = field_of(turning_metric(0.01, 40, 2), mesh);
  MetricField field = given;
  const TurningResult result = limit_turning(field, mesh.view());
  REQUIRE(result.turns);
  REQUIRE(result.followed < 4 * result.asked);
  for (std::size_t v = 0; v < field.size(); ++v) {
    const EigenSystem now = eigen(field.logs[v]), before = eigen(given.logs[v]);
    for (std::size_t i = 0; i < 3; ++i) CHECK(now.values[i] >= before.values[i] - 1e-9);
    CHECK(std::abs(now.values[2] - before.values[2]) < 1e-9);
  }
}

TEST_CASE("limits of turning do not depend on the loop, and take any metric", "[turning]") {
  const BoxMesh mesh = make_box_mesh(5, 0.2);
  RandomTensors random(4);
  for (const double aspect : {10.0, 1e3, 1e6, 1e60}) {
    MetricField metric;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      EigenSystem e = random.metric(1e-3, aspect);
      for (double& value : e.values) value = std::log(value);
      metric.logs.push_back(compose(e));
    }
    MetricField one = metric, other = metric;
    const TurningResult result = limit_turning(one, mesh.view());
    CHECK(result.turns == (aspect > 100));
    CHECK(limit_turning(other, mesh.view(), test::BackwardsLoop()).turns == result.turns);
    CHECK(one.logs == other.logs);
    for (const Tensor& logarithm : one.logs) CHECK(is_finite(logarithm));
  }
}

TEST_CASE("a metric from a solution that turns has the complexity asked for", "[turning]") {
  const BoxMesh mesh = make_box_mesh(16, 0.1);
  std::vector<double> values;
  for (const Vec3& x : mesh.points) values.push_back(std::tanh(50 * (x.x + 0.3 * std::sin(5 * x.y) - 0.6)));
  HessianOptions options;
  options.complexity = 500;
  const HessianMetric metric = metric_from_solution(values, mesh.view(), options);
  CHECK(std::abs(metric.complexity / 500 - 1) < 0.02);
  CHECK(std::abs(complexity(metric.metric, mesh.view()) - metric.complexity) < 1e-9 * metric.complexity);
  MetricField limited = metric.metric;
  CHECK(!limit_turning(limited, mesh.view()).turns);
}
