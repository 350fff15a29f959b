#pragma once
// Cutting a facet until one size describes each piece. Private to mesher/sizing.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "mesher/sizing/source_tree.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// A corner of a piece of a facet.
struct FacetCorner {
  Vec2 uv;
  Vec3 point;
};

/// A piece of a facet, by its corners.
using FacetPiece = std::array<FacetCorner, 3>;

/// When a piece needs no further cut.
struct FacetRules {
  double global = 0;          ///< sizes from here on make no source
  double cap = HUGE_VAL;      ///< a size that holds on the whole facet
  double longest = HUGE_VAL;  ///< pieces with longer edges are always cut
  double spread = 1.15;       ///< pieces whose sizes differ by more are cut …
  double finest = 0.5;        ///< … unless their edges are shorter than this times their smallest size
  int depth = 24;             ///< of halvings, at most; a cut into four counts as two
};

/// Two or four pieces of a piece.
template <class Middle>
std::vector<FacetPiece> cut_piece(const FacetPiece& piece, const Middle& middle) {
  constexpr double kSliver = 0.4;  // height over longest edge; 0.87 for an equilateral triangle
  FacetPiece p = piece;            // turned so that a b is the longest edge
  const auto length2 = [&](int i) { return norm2(piece[(i + 1) % 3].point - piece[i].point); };
  for (int i = 1; i < 3; ++i)
    if (length2(i) > norm2(p[1].point - p[0].point)) p = {piece[i], piece[(i + 1) % 3], piece[(i + 2) % 3]};
  const auto& [a, b, c] = p;
  const double base2 = norm2(b.point - a.point), area2 = norm2(cross(b.point - a.point, c.point - a.point));
  const FacetCorner ab = middle(a, b);
  if (area2 < kSliver * kSliver * base2 * base2) return {{a, ab, c}, {ab, b, c}};
  const FacetCorner bc = middle(b, c), ca = middle(c, a);
  return {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}};
}

/// Appends sources that cover those pieces of a facet on which the size is below the global one.
///
/// `size_at(piece, weights)` samples a size at a point inside a piece, given by its barycentric weights; samples lie
/// inside because parametrisations degenerate on boundaries (poles, apexes) and not inside. `middle(a, b)` halves an
/// edge. A piece gets the smallest of its samples, so that the size asked for is never exceeded where it was sampled.
/// Slivers are halved, other pieces cut into four.
template <class SizeAt, class Middle>
void refine_facet(const FacetPiece& piece, const FacetRules& rules, const SizeAt& size_at, const Middle& middle,
                  std::vector<SizeSource>& out) {
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
  const bool varies = largest > rules.spread * smallest && longest > rules.finest * smallest;
  if (rules.depth > 0 && (varies || longest > rules.longest)) {
    const std::vector<FacetPiece> parts = cut_piece(piece, middle);
    FacetRules below = rules;
    below.depth -= parts.size() == 2 ? 1 : 2;
    for (const FacetPiece& part : parts) refine_facet(part, below, size_at, middle, out);
    return;
  }
  if (smallest < rules.global) out.push_back({a.point, b.point, c.point, smallest});
}

}  // namespace tetloom
