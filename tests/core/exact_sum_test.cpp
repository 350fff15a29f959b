// Sums that do not depend on the order of what is added.
#include "core/base/exact_sum.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

using namespace tetloom;

namespace {

ExactSum sum_of(const std::vector<double>& values) {
  ExactSum sum;
  for (const double value : values) sum.add(value);
  return sum;
}

}  // namespace

TEST_CASE("sums are the same in any order and dealt in any way", "[exact_sum]") {
  for (unsigned seed = 0; seed < 200; ++seed) {
    CAPTURE(seed);
    std::mt19937_64 random(seed);
    std::vector<double> values;
    for (std::size_t i = 0; i < 1 + seed % 40; ++i) {
      const double mantissa = static_cast<double>(static_cast<std::int64_t>(random()));
      values.push_back(std::ldexp(mantissa, static_cast<int>(random() % 300) - 150));
    }
    const double expected = sum_of(values).value();
    std::vector<double> shuffled = values;
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    CHECK(sum_of(shuffled).value() == expected);
    ExactSum odd, even;
    for (std::size_t i = 0; i < values.size(); ++i) (i % 2 == 0 ? even : odd).add(values[i]);
    odd.add(even);
    CHECK(odd.value() == expected);
    long double near = 0, most = 0;
    for (const double value : values) near += value, most += std::abs(value);
    CHECK(std::abs(static_cast<double>(expected - near)) <= 2e-16 * static_cast<double>(most));
  }
}

TEST_CASE("sums are exact where rounding in between would lose everything", "[exact_sum]") {
  CHECK(sum_of({1e300, 1, -1e300}).value() == 1);
  CHECK(sum_of({1e308, 1e308, -1e308}).value() == 1e308);
  CHECK(sum_of({5e-324, 5e-324, -1, 1}).value() == 1e-323);
  CHECK(sum_of({0.1, -0.3}).value() == 0.1 - 0.3);
  CHECK(sum_of({1, std::ldexp(1.0, -53)}).value() == 1);  // a tie goes to the even one
  CHECK(sum_of({1, std::ldexp(1.0, -53), std::ldexp(1.0, -200)}).value() == 1 + std::ldexp(1.0, -52));
  CHECK(sum_of({}).value() == 0);
}

TEST_CASE("what is not finite stays so", "[exact_sum]") {
  const double inf = std::numeric_limits<double>::infinity();
  CHECK(sum_of({1, inf}).value() == inf);
  CHECK(sum_of({-inf, 1}).value() == -inf);
  CHECK(std::isnan(sum_of({-inf, inf}).value()));
  CHECK(std::isnan(sum_of({NAN, 1}).value()));
}

TEST_CASE("words of several sums may be added up as integers", "[exact_sum]") {
  ExactSum one = sum_of({0.1, 1e10, -7}), other = sum_of({-3e-5, 0.7});
  const double expected = sum_of({0.1, 1e10, -7, -3e-5, 0.7}).value();
  one.carry(), other.carry();
  for (std::size_t i = 0; i < one.words().size(); ++i) one.words()[i] += other.words()[i];
  CHECK(one.value() == expected);
}
