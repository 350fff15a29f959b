#include "bench/support/plot_axis.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace tetloom::bench {
namespace {

constexpr double kIntervals = 5;  // about so many between ticks of a linear axis
constexpr double kEpsilon = 1e-9;

/// 1, 2 or 5 times a power of ten, at least `value`.
double nice_step(double value) {
  const double power = std::pow(10, std::floor(std::log10(value) + kEpsilon));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= value * (1 - kEpsilon)) return factor * power;
  return 10 * power;
}

/// The 1s, 2s and 5s of all powers of ten from the last one <= low to the first one >= high.
std::vector<double> nice_values(double low, double high) {
  std::vector<double> values;
  const int first = static_cast<int>(std::floor(std::log10(low))) - 1;
  const int last = static_cast<int>(std::ceil(std::log10(high))) + 1;
  for (int power = first; power <= last; ++power)
    for (const double factor : {1.0, 2.0, 5.0}) values.push_back(factor * std::pow(10, power));
  const auto begin = std::prev(std::upper_bound(values.begin(), values.end(), low * (1 + kEpsilon)));
  const auto end = std::next(std::lower_bound(values.begin(), values.end(), high * (1 - kEpsilon)));
  return {begin, end};
}

bool is_power_of_ten(double value) {
  const double power = std::log10(value);
  return std::abs(power - std::round(power)) < kEpsilon;
}

}  // namespace

std::string short_number(double value) {
  char text[48];
  for (const auto& [unit, name] : {std::pair(1e9, "G"), std::pair(1e6, "M"), std::pair(1e3, "k")})
    if (std::abs(value) >= unit * (1 - kEpsilon)) {
      std::snprintf(text, sizeof(text), "%.4g %s", value / unit, name);
      return text;
    }
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

AxisRange::AxisRange(const Axis& axis, std::span<const double> values) : scale_(axis.scale), ticks_(axis.ticks) {
  std::vector<double> all;
  for (const double value : values) all.push_back(value);
  if (all.empty()) throw std::invalid_argument("a plot without values");
  for (const Tick& tick : ticks_) all.push_back(tick.value);
  for (const double value : all) {
    if (!std::isfinite(value)) throw std::invalid_argument("a plot of values that are no numbers");
    if (scale_ == Scale::Log && value <= 0) throw std::invalid_argument("a plot of logarithms of values <= 0");
  }
  if (scale_ == Scale::Linear && axis.from_zero) all.push_back(0);
  const auto [least, most] = std::minmax_element(all.begin(), all.end());
  low_ = *least, high_ = *most;
  scale_ == Scale::Log ? round_logarithms() : round_linear();
}

void AxisRange::round_linear() {
  if (high_ == low_) high_ = low_ + (low_ == 0 ? 1 : std::abs(low_));
  if (!ticks_.empty()) return;
  const double step = nice_step((high_ - low_) / kIntervals);
  const double first = std::floor(low_ / step + kEpsilon), last = std::ceil(high_ / step - kEpsilon);
  for (double i = first; i <= last; ++i) ticks_.push_back({i * step, short_number(i * step)});
  low_ = first * step, high_ = last * step;
}

void AxisRange::round_logarithms() {
  if (!ticks_.empty()) {
    if (high_ == low_) high_ = 2 * low_;
    return;
  }
  const std::vector<double> values = nice_values(low_, std::max(high_, 1.1 * low_));
  low_ = values.front(), high_ = values.back();
  // Over many powers of ten only these are told.
  const bool all = high_ / low_ <= 1000;
  for (const double value : values)
    if (all || is_power_of_ten(value)) ticks_.push_back({value, short_number(value)});
}

double AxisRange::place(double value) const {
  if (scale_ == Scale::Linear) return (value - low_) / (high_ - low_);
  return std::log(value / low_) / std::log(high_ / low_);
}

}  // namespace tetloom::bench
