#pragma once
// Cutting a facet until one size describes each piece. Private to mesher/sizing.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/vec.hpp"
#include "mesher/sizing/source_tree.hpp"

namespace tetloom {

/// A corner of a piece of a facet.
struct FacetCorner {
  Vec2 uv;
  Vec3 point;
};

using FacetPiece = std::array<FacetCorner, 3>;

/// When a piece needs no further cut.
struct FacetRules {
  double global = 0;          ///< sizes from here on make no source
  double cap = HUGE_VAL;      ///< a size that holds on the whole facet
  double longest = HUGE_VAL;  ///< pieces with longer edges are always cut
  int depth = 12;             ///< of cuts into four
};

/// Appends sources that cover those pieces of a facet on which the size is below the global one.
///
/// `size_at(piece, weights)` samples a size at a point inside a piece, given by its barycentric weights; samples lie
/// inside because parametrisations degenerate on boundaries (poles, apexes) and not inside. `middle(a, b)` halves an
/// edge. A piece is cut while its samples differ by more than 15 % and its longest edge exceeds half the smallest; it
/// gets the smallest, so that the size asked for is never exceeded where it was sampled.
template <class SizeAt, class Middle>
void refine_facet(const FacetPiece& piece, const FacetRules& rules, const SizeAt& size_at, const Middle& middle,
                  std::vector<SizeSource>& out) {
  constexpr double kSpread = 1.15;
  constexpr std::array<std::array<double, 3>, 4> kSamples{
      {{1.0 / 3, 1.0 / 3, 1.0 / 3}, {0.7, 0.15, 0.15}, {0.15, 0.7, 0.15}, {0.15, 0.15, 0.7}}};
  const auto& [a, b, c] = piece;
  const double longest =
      std::sqrt(std::max({norm2(b.point - a.point), norm2(c.point - b.point), norm2(a.point - c.point)}));
  double smallest = std::min(rules.cap, rules.global), largest = 0;
  for (const std::array<double, 3>& weights : kSamples) {
    const double size = std::min({size_at(piece, weights), rules.cap, rules.global});
    smallest = std::min(smallest, size);
    largest = std::max(largest, size);
  }
  const bool varies = largest > kSpread * smallest && longest > 0.5 * smallest;
  if (rules.depth > 0 && (varies || longest > rules.longest)) {
    FacetRules below = rules;
    --below.depth;
    const FacetCorner ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const FacetPiece& part : {FacetPiece{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
      refine_facet(part, below, size_at, middle, out);
    return;
  }
  if (smallest < rules.global) out.push_back({a.point, b.point, c.point, smallest});
}

}  // namespace tetloom
