#include "tetloom/metric.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/adapt/random_tensors.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

double orthonormality_error(const EigenSystem& e) {
  double error = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      error = std::max(error, std::abs(dot(e.vectors[i], e.vectors[j]) - (i == j ? 1.0 : 0.0)));
  return std::max(error, distance(cross(e.vectors[0], e.vectors[1]), e.vectors[2]));
}

void check_eigen(const Tensor& m) {
  const EigenSystem e = eigen(m);
  CAPTURE(m.xx, m.xy, m.yy, m.xz, m.yz, m.zz);
  CHECK(orthonormality_error(e) < 1e-14);
  CHECK(largest_entry(compose(e) - m) <= 1e-14 * largest_entry(m));
  CHECK(e.values[0] <= e.values[1]);
  CHECK(e.values[1] <= e.values[2]);
}

}  // namespace

TEST_CASE("a tensor measures vectors as the matrix of its entries does", "[tensor]") {
  const Tensor m{4, 1, 5, -2, 0.5, 6};
  CHECK(dot(m, Vec3{1, 0, 0}) == 4);
  CHECK(dot(m, Vec3{1, 1, 0}) == 4 + 5 + 2);
  CHECK(dot(m, Vec3{1, 2, 3}) == 4 + 20 + 54 + 2 * (2 - 6 + 3));
  CHECK(dot(Vec3{1, 2, 3}, m, Vec3{1, 2, 3}) == dot(m, Vec3{1, 2, 3}));
  CHECK(m * Vec3{0, 0, 1} == Vec3{-2, 0.5, 6});
  CHECK(det(m) == Approx(4 * (30 - 0.25) - 1 * (6 + 1) - 2 * (0.5 + 10)));
  CHECK(trace(m) == 15);
  CHECK(isotropic(0.5) == diagonal(4, 4, 4));
}

TEST_CASE("eigenvectors are orthonormal for any eigenvalues, repeated ones as well", "[tensor]") {
  const unsigned seed = 20261122;
  CAPTURE(seed);
  RandomTensors random(seed);
  check_eigen({});
  check_eigen(isotropic(3));
  check_eigen(diagonal(3, -1, 2));
  check_eigen({0, 1, 0, 1, 1, 0});
  check_eigen({1, 1e-200, 1, 1e-300, 0, 1});
  check_eigen({1e200, 1e199, 1e200, -1e199, 0, 3e200});
  for (int i = 0; i < 3000; ++i) {
    check_eigen(random.tensor());
    EigenSystem e = random.metric(0.01, 1e4);
    check_eigen(compose(e));
    e.values[1] = e.values[0];
    check_eigen(compose(e));
    e.values[2] = e.values[0] * (1 + 1e-12);
    check_eigen(compose(e));
  }
}

TEST_CASE("eigenvalues along the axes are exact up to an aspect ratio of 1e8", "[tensor]") {
  const EigenSystem e = eigen(diagonal(1e16, 1, 1e8));
  CHECK(e.values == std::array<double, 3>{1, 1e8, 1e16});
  CHECK(std::abs(e.vectors[0].y) == 1);
  CHECK(is_positive_definite(diagonal(1e16, 1, 1e8)));
}

TEST_CASE("eigenvalues of turned metrics are found again", "[tensor]") {
  const unsigned seed = 7;
  CAPTURE(seed);
  RandomTensors random(seed);
  for (int i = 0; i < 2000; ++i) {
    EigenSystem e = random.metric(0.001, 1e6);
    const EigenSystem found = eigen(compose(e));
    std::sort(e.values.begin(), e.values.end());
    for (std::size_t k = 0; k < 3; ++k) CHECK(std::abs(found.values[k] - e.values[k]) <= 1e-14 * e.values[2]);
  }
}

TEST_CASE("only finite tensors with positive eigenvalues are metrics", "[tensor]") {
  CHECK(is_positive_definite(isotropic(1e-3)));
  CHECK_FALSE(is_positive_definite({}));
  CHECK_FALSE(is_positive_definite(diagonal(1, 0, 1)));
  CHECK_FALSE(is_positive_definite(diagonal(1, -1e-9, 1)));
  CHECK_FALSE(is_positive_definite({1, 2, 1, 0, 0, 1}));
  CHECK_FALSE(is_positive_definite(diagonal(1, std::numeric_limits<double>::quiet_NaN(), 1)));
  CHECK_FALSE(is_positive_definite(diagonal(1, std::numeric_limits<double>::infinity(), 1)));
}

TEST_CASE("exponential and logarithm undo each other", "[tensor]") {
  const unsigned seed = 8;
  CAPTURE(seed);
  RandomTensors random(seed);
  CHECK(tetloom::adapt::log(isotropic(0.5)) == log_isotropic(0.5));
  CHECK(tetloom::adapt::exp(Tensor{}) == diagonal(1, 1, 1));
  for (int i = 0; i < 2000; ++i) {
    const Tensor m = compose(random.metric(0.01, 1e3));
    CHECK(largest_entry(exp(log(m)) - m) <= 1e-12 * largest_entry(m));
    CHECK(det(m) == Approx(std::exp(trace(log(m)))).epsilon(1e-6));
    // An aspect ratio of 1e8 survives in the logarithm.
    EigenSystem e = random.metric(1, 1);
    e.values = {std::log(1e16), 0, std::log(1e8)};
    const EigenSystem kept = eigen(compose(e));
    CHECK(std::abs(kept.values[0]) < 1e-13);
    CHECK(kept.values[2] == Approx(e.values[0]).epsilon(1e-14));
  }
}

TEST_CASE("the exponential is that of the eigenvalues, however anisotropic", "[tensor]") {
  const unsigned seed = 10;
  CAPTURE(seed);
  RandomTensors random(seed);
  for (int i = 0; i < 3000; ++i) {
    const double range = random.uniform(0, 1) * (i % 3 == 0 ? 0.1 : i % 3 == 1 ? 12 : 60);
    const double mean = random.uniform(-20, 20);
    EigenSystem e;
    e.vectors = random.basis();
    for (double& value : e.values) value = mean + random.uniform(-0.5, 0.5) * range;
    if (i % 4 == 0) e.values[1] = e.values[2];
    const Tensor logarithm = compose(e);
    for (double& value : e.values) value = std::exp(value);
    const Tensor expected = compose(e);
    CAPTURE(range);
    CHECK(largest_entry(exp(logarithm) - expected) <= 1e-13 * largest_entry(expected));
    if (range < 30) CHECK(is_positive_definite(exp(logarithm)));
  }
}

TEST_CASE("edges have the logarithmic mean of their lengths at both ends", "[tensor]") {
  const Vec3 e{0, 0, 2};
  CHECK(edge_length(isotropic(1), isotropic(1), e) == 2);
  CHECK(edge_length(isotropic(1), isotropic(0.5), e) == Approx(2 / std::log(2.0)).epsilon(1e-14));
  CHECK(edge_length(isotropic(0.5), isotropic(1), e) == edge_length(isotropic(1), isotropic(0.5), e));
  CHECK(edge_length(isotropic(1), isotropic(1), Vec3{}) == 0);
  CHECK(logarithmic_mean(0, 1) == 0);
  for (double ratio = 1; ratio < 1.3; ratio += 0.0007) {  // across the change from the series to the formula
    CAPTURE(ratio);
    const double expected = ratio < 1.0000001 ? 1 : (ratio - 1) / std::log1p(ratio - 1);
    CHECK(logarithmic_mean(1, ratio) == Approx(expected).epsilon(1e-11));
    CHECK(logarithmic_mean(1, ratio) == logarithmic_mean(ratio, 1));
  }
}

TEST_CASE("an intersection of metrics asks for the smaller size in every direction", "[tensor]") {
  const unsigned seed = 9;
  CAPTURE(seed);
  RandomTensors random(seed);
  CHECK(intersection(diagonal(1, 4, 9), diagonal(4, 1, 1)) == diagonal(4, 4, 9));
  CHECK(intersection(isotropic(1), isotropic(2)) == isotropic(1));
  for (int i = 0; i < 2000; ++i) {
    const double aspect = i % 2 == 0 ? 1e2 : 1e5;
    const Tensor a = compose(random.metric(0.01, aspect)), b = compose(random.metric(0.02, aspect));
    const Tensor both = intersection(a, b);
    CHECK(is_finite(both));
    for (int k = 0; k < 10; ++k) {
      const Vec3 e = random.vector();
      const double scale = 1e-12 * (largest_entry(a) + largest_entry(b)) * norm2(e);
      CHECK(dot(both, e) >= std::max(dot(a, e), dot(b, e)) - scale);
      CHECK(dot(both, e) <= dot(a, e) + dot(b, e) + scale);
    }
    CHECK(largest_entry(intersection(b, a) - both) <= 1e-6 * largest_entry(both));
    CHECK(intersection(a, a) == a);
  }
}
