#include "core/cad/detail/gauss_rule.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "tetloom/assert.hpp"

namespace tetloom::cad {
namespace {

struct Legendre {
  double value, slope;
};

/// The Legendre polynomial of degree n >= 1 inside (-1, 1), by its three-term recurrence.
Legendre legendre(int n, double x) {
  double before = 1, value = x;
  for (int k = 2; k <= n; ++k) {
    const double next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
    before = value, value = next;
  }
  return {value, n * (before - x * value) / (1 - x * x)};
}

std::vector<GaussNode> make_rule(int count) {
  std::vector<GaussNode> rule;
  for (int i = 0; i < count; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    for (int step = 0; step < 8; ++step) {
      const Legendre p = legendre(count, x);
      x -= p.value / p.slope;
    }
    const double slope = legendre(count, x).slope;
    rule.push_back({x, 2 / ((1 - x * x) * slope * slope)});
  }
  return rule;
}

}  // namespace

std::span<const GaussNode> gauss_rule(int count) {
  TETLOOM_ASSERT(count >= 1 && count <= kMostGaussNodes);
  static const auto rules = [] {
    std::array<std::vector<GaussNode>, kMostGaussNodes> all;
    for (int n = 1; n <= kMostGaussNodes; ++n) all[static_cast<std::size_t>(n - 1)] = make_rule(n);
    return all;
  }();
  return rules[static_cast<std::size_t>(count - 1)];
}

}  // namespace tetloom::cad
