#pragma once
// Gauss-Legendre quadrature on [-1, 1]. Private to core/cad. Thread safety: any number of threads.
#include <span>

namespace tetloom::cad {

/// A place and its weight on [-1, 1].
struct GaussNode {
  double x, weight;
};

constexpr int kMostGaussNodes = 16;

/// The rule with `count` points, 1 to kMostGaussNodes; exact for polynomials of degree 2 count - 1.
std::span<const GaussNode> gauss_rule(int count);

}  // namespace tetloom::cad
