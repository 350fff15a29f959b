#include "mesher/sizing/narrow_entities.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace tetloom {

double mean_width(const Tessellation& facets) {
  std::vector<std::array<std::uint32_t, 2>> sides;
  double area = 0;
  for (const auto& tri : facets.tri_to_vert) {
    const Vec3 &a = facets.points[tri[0]], &b = facets.points[tri[1]], &c = facets.points[tri[2]];
    area += 0.5 * norm(cross(b - a, c - a));
    for (std::size_t i = 0; i < 3; ++i)
      sides.push_back({std::min(tri[i], tri[(i + 1) % 3]), std::max(tri[i], tri[(i + 1) % 3])});
  }
  std::ranges::sort(sides);
  double rim = 0;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool shared = (i > 0 && sides[i - 1] == sides[i]) || (i + 1 < sides.size() && sides[i + 1] == sides[i]);
    if (!shared) rim += distance(facets.points[sides[i][0]], facets.points[sides[i][1]]);
  }
  return rim > 0 ? 2 * area / rim : HUGE_VAL;
}

double length_up_to(EdgeGeometry& edge, double most) {
  constexpr int kPieces = 16;
  const ParameterRange range = edge.range();
  Vec3 before = edge.evaluate(range.lo);
  double length = 0;
  for (int i = 1; i <= kPieces && length < most; ++i) {
    const Vec3 point = edge.evaluate(range.lo + (range.hi - range.lo) * i / kPieces);
    length += distance(before, point);
    before = point;
  }
  return length;
}

}  // namespace tetloom
