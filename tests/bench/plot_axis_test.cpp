#include "bench/support/plot_axis.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <stdexcept>

using namespace tetloom::bench;

namespace {

std::vector<std::string> labels(const AxisRange& range) {
  std::vector<std::string> texts;
  for (const Tick& tick : range.ticks()) texts.push_back(tick.label);
  return texts;
}

AxisRange range_of(const Axis& axis, const std::vector<double>& values) { return {axis, values}; }

using Texts = std::vector<std::string>;

}  // namespace

TEST_CASE("numbers are told in a few characters") {
  CHECK(short_number(0) == "0");
  CHECK(short_number(0.05) == "0.05");
  CHECK(short_number(20) == "20");
  CHECK(short_number(1000) == "1 k");
  CHECK(short_number(2.5e6) == "2.5 M");
  CHECK(short_number(3e8) == "300 M");
  CHECK(short_number(1e9) == "1 G");
}

TEST_CASE("a linear axis begins at 0 unless it need not, and is told in round numbers") {
  const Axis axis{"s"};
  CHECK(labels(range_of(axis, {3, 9.7})) == Texts{"0", "2", "4", "6", "8", "10"});
  CHECK(labels(range_of(axis, {0.021})) == Texts{"0", "0.005", "0.01", "0.015", "0.02", "0.025"});
  CHECK(labels(range_of({"s", Scale::Linear, {}, false}, {103, 107})) == Texts{"103", "104", "105", "106", "107"});
  CHECK(range_of(axis, {0, 0}).high() > 0);
  CHECK(range_of({"s", Scale::Linear, {}, false}, {5}).place(5) == Approx(0));
}

TEST_CASE("an axis of logarithms is told in 1s, 2s and 5s, over many powers of ten in these alone") {
  const Axis axis{"tets", Scale::Log};
  CHECK(labels(range_of(axis, {1.2e6, 1.9e7})) == Texts{"1 M", "2 M", "5 M", "10 M", "20 M"});
  CHECK(labels(range_of(axis, {1, 64})) == Texts{"1", "2", "5", "10", "20", "50", "100"});
  CHECK(labels(range_of(axis, {0.3, 4000})) == Texts{"1", "10", "100", "1 k"});
  CHECK(range_of(axis, {7}).low() == Approx(5));
  CHECK(range_of(axis, {7}).high() == Approx(10));
  CHECK(range_of(axis, {5}).place(5) == Approx(0));
  const AxisRange range = range_of(axis, {1, 100});
  CHECK(range.place(1) == Approx(0).margin(1e-12));
  CHECK(range.place(10) == Approx(0.5));
  CHECK(range.place(100) == Approx(1));
}

TEST_CASE("ticks that are given are the ticks, and lie on the axis") {
  const AxisRange range = range_of({"threads", Scale::Log, {{1, "one"}, {16, "sixteen"}}}, {2, 4});
  CHECK(labels(range) == Texts{"one", "sixteen"});
  CHECK(range.place(4) == Approx(0.5));
}

TEST_CASE("all values and ticks lie on their axis") {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> exponent(-6, 9);
  for (int i = 0; i < 500; ++i) {
    const std::vector<double> values{std::pow(10, exponent(generator)), std::pow(10, exponent(generator))};
    CAPTURE(values[0], values[1]);
    for (const Scale scale : {Scale::Linear, Scale::Log}) {
      const AxisRange range = range_of({"x", scale}, values);
      REQUIRE(range.ticks().size() >= (scale == Scale::Linear ? 2 : 1));
      CHECK(range.ticks().size() <= 16);
      for (const double value : values) CHECK(std::abs(range.place(value) - 0.5) <= 0.5 + 1e-6);
      for (const Tick& tick : range.ticks()) CHECK(std::abs(range.place(tick.value) - 0.5) <= 0.5 + 1e-6);
    }
  }
}

TEST_CASE("an axis refuses what has no place on it") {
  CHECK_THROWS_AS(range_of({"x"}, {}), std::invalid_argument);
  CHECK_THROWS_AS(range_of({"x"}, {1, NAN}), std::invalid_argument);
  CHECK_THROWS_AS(range_of({"x"}, {HUGE_VAL}), std::invalid_argument);
  CHECK_THROWS_AS(range_of({"x", Scale::Log}, {1, 0}), std::invalid_argument);
  CHECK_THROWS_AS(range_of({"x", Scale::Log, {{-1, "-1"}}}, {1}), std::invalid_argument);
  CHECK_NOTHROW(range_of({"x"}, {-1, 0}));
}
