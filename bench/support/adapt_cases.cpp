#include "bench/support/adapt_cases.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace tetloom::bench {
namespace {

using adapt::outer;
using adapt::Tensor;

constexpr double kSmallest = 0.001, kLargest = 0.1;

/// Sizes on both sides of 1/2.
double linear_size(double place) { return kSmallest + 2 * (kLargest - kSmallest) * std::abs(place - 0.5); }

double inverse_square(double size) { return 1 / (size * size); }

Tensor polar_metric(const Vec3& x, bool finer_around) {
  const double radius = std::hypot(x.x, x.y), angle = std::atan2(x.y, x.x);
  const double share = finer_around ? std::min(10 * std::abs(radius - 0.5), 1.0) : 1.0;
  const double around = kLargest * share + 0.25 * kLargest * (1 - share);
  const Vec3 out{std::cos(angle), std::sin(angle), 0}, along{-out.y, out.x, 0};
  return outer(out, inverse_square(linear_size(radius))) + outer(along, inverse_square(around)) +
         adapt::diagonal(0, 0, inverse_square(kLargest));
}

struct Shock {
  double radius = 0, across = 0.002, along = 0.02;

  Tensor at(const Vec3& x) const {
    constexpr double kGrowth = 0.2;
    const double distance = norm(x);
    const Vec3 out = distance < 1e-12 ? Vec3{1, 0, 0} : x * (1 / distance);
    const double away = kGrowth * std::abs(distance - radius);
    const double a = inverse_square(std::min(across + away, kLargest));
    const double b = inverse_square(std::min(along + away, kLargest));
    return outer(out, a - b) + adapt::diagonal(b, b, b);
  }
};

/// The positive numbers behind `name` and a colon.
std::vector<double> numbers_of(const std::string& text, const std::string& name) {
  std::vector<double> numbers;
  std::istringstream stream(text.substr(std::min(text.size(), name.size() + 1)));
  for (std::string word; std::getline(stream, word, ',');) {
    std::size_t used = 0;
    const double value = std::stod(word, &used);
    if (used != word.size() || !(value > 0) || !std::isfinite(value)) throw std::invalid_argument(word);
    numbers.push_back(value);
  }
  return numbers;
}

AnalyticMetric plain_metric(const std::string& name) {
  if (name == "cube-linear")
    return [](const Vec3& x) {
      return adapt::diagonal(inverse_square(kLargest), inverse_square(kLargest), inverse_square(linear_size(x.z)));
    };
  if (name == "polar-1" || name == "polar-2")
    return [finer_around = name == "polar-2"](const Vec3& x) { return polar_metric(x, finer_around); };
  if (name.starts_with("iso:")) {
    const auto numbers = numbers_of(name, "iso");
    if (numbers.size() == 1) return [h = numbers[0]](const Vec3&) { return adapt::isotropic(h); };
  }
  if (name.starts_with("shock:")) {
    const auto numbers = numbers_of(name, "shock");
    if (numbers.size() == 1) return [shock = Shock{numbers[0]}](const Vec3& x) { return shock.at(x); };
    if (numbers.size() == 3)
      return [shock = Shock{numbers[0], numbers[1], numbers[2]}](const Vec3& x) { return shock.at(x); };
  }
  throw std::invalid_argument(name);
}

}  // namespace

AnalyticMetric analytic_metric(const std::string& name) {
  try {
    const std::size_t star = name.find('*');
    const AnalyticMetric metric = plain_metric(name.substr(0, star));
    if (star == std::string::npos) return metric;
    const std::vector<double> factor = numbers_of(name.substr(star), "");
    if (factor.size() != 1) throw std::invalid_argument(name);
    return [metric, square = factor[0] * factor[0]](const Vec3& x) { return square * metric(x); };
  } catch (const std::logic_error&) {  // of numbers, too
    throw std::invalid_argument("'" + name +
                                "' is no metric; there are iso:H, cube-linear, polar-1, polar-2 and shock:R[,HN,HT]");
  }
}

AdaptCase find_adapt_case(const std::string& name) {
  if (name == "iso") return {name, {"iso:0.022"}};
  if (name == "shock") return {name, {"shock:0.5,0.001,0.009"}};
  if (name == "moving-shock") return {name, {"shock:0.44", "shock:0.48", "shock:0.52", "shock:0.56", "shock:0.60"}};
  analytic_metric(name);
  return {name, {name}};
}

std::vector<std::string> adapt_case_names() { return {"iso", "cube-linear", "polar-2", "shock", "moving-shock"}; }

std::vector<std::string> quick_adapt_case_names() { return {"iso:0.08", "polar-2*0.4"}; }

}  // namespace tetloom::bench
