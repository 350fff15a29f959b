#include "bench/support/adapt_cases.hpp"

#include <catch2/catch.hpp>
#include <stdexcept>

using namespace tetloom;
using namespace tetloom::bench;

namespace {

/// The size that `name` asks for at `x` along `direction`, a unit vector that is an eigenvector there.
double size_along(const std::string& name, const Vec3& x, const Vec3& direction) {
  const adapt::Tensor metric = analytic_metric(name)(x);
  CHECK(adapt::is_positive_definite(metric));
  const Vec3 image = metric * direction;
  CHECK(norm(cross(image, direction)) < 1e-9 * norm(image));
  return 1 / std::sqrt(dot(metric, direction));
}

const Vec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};

}  // namespace

TEST_CASE("sizes of the metrics that meshers are compared by") {
  CHECK(size_along("iso:0.022", {0.3, 0.1, 0.9}, kY) == Approx(0.022));
  CHECK(size_along("cube-linear", {0.3, 0.1, 0.5}, kZ) == Approx(0.001));
  CHECK(size_along("cube-linear", {0.3, 0.1, 0}, kZ) == Approx(0.1));
  CHECK(size_along("cube-linear", {0.3, 0.1, 0.75}, kZ) == Approx(0.0505));
  CHECK(size_along("cube-linear", {0.3, 0.1, 0.5}, kX) == Approx(0.1));
  for (const std::string name : {"polar-1", "polar-2"}) {
    CHECK(size_along(name, {0.3, 0.4, 0.7}, {0.6, 0.8, 0}) == Approx(0.001));
    CHECK(size_along(name, {0.3, 0.4, 0.7}, {-0.8, 0.6, 0}) == Approx(name == "polar-1" ? 0.1 : 0.025));
    CHECK(size_along(name, {0.3, 0.4, 0.7}, kZ) == Approx(0.1));
    CHECK(size_along(name, {0, 0, 0.7}, kZ) == Approx(0.1));
  }
  CHECK(size_along("polar-2", {0.55, 0, 0}, kY) == Approx(0.0625));
  CHECK(size_along("polar-2", {0.75, 0, 0}, kY) == Approx(0.1));
}

TEST_CASE("sizes at a shock") {
  CHECK(size_along("shock:0.5", {0.5, 0, 0}, kX) == Approx(0.002));
  CHECK(size_along("shock:0.5", {0.5, 0, 0}, kY) == Approx(0.02));
  CHECK(size_along("shock:0.5,0.001,0.009", {0, 0.5, 0}, kY) == Approx(0.001));
  CHECK(size_along("shock:0.5,0.001,0.009", {0, 0.7, 0}, kY) == Approx(0.041));
  CHECK(size_along("shock:0.5,0.001,0.009", {0, 0.7, 0}, kZ) == Approx(0.049));
  CHECK(size_along("shock:0.5", {0, 0, 1.2}, kZ) == Approx(0.1));
  CHECK(size_along("shock:0.5", {0, 0, 0}, kX) == Approx(0.1));
}

TEST_CASE("a factor divides all sizes") {
  CHECK(size_along("iso:0.1*4", {}, kX) == Approx(0.025));
  CHECK(size_along("shock:0.5*0.5", {0.5, 0, 0}, kX) == Approx(0.004));
}

TEST_CASE("cases are sequences of metrics") {
  for (const std::string& name : adapt_case_names()) {
    CHECK(find_adapt_case(name).metrics.size() == (name == "moving-shock" ? 5 : 1));
    for (const std::string& metric : find_adapt_case(name).metrics) CHECK(analytic_metric(metric) != nullptr);
  }
  for (const std::string& name : quick_adapt_case_names()) CHECK(find_adapt_case(name).metrics == std::vector{name});
}

TEST_CASE("names that are no metric are refused") {
  for (const char* name :
       {"", "cube", "iso", "iso:", "iso:x", "iso:0.1x", "iso:-1", "iso:0", "iso:nan", "iso:inf", "iso:1,2",
        "shock:", "shock:0.5,0.1", "shock:0.5,0.1,0.1,0.1", "iso:0.1*", "iso:0.1*0", "iso:0.1*2*3", "iso:1e999"}) {
    CAPTURE(name);
    CHECK_THROWS_AS(analytic_metric(name), std::invalid_argument);
  }
  CHECK_THROWS_AS(find_adapt_case("isotropic"), std::invalid_argument);
}
