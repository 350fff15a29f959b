#pragma once
// Where small sizes come from, and the size that they allow at any point. Private to mesher/sizing.
#include <cstdint>
#include <vector>

#include "core/base/vec.hpp"
#include "mesher/sizing/bvh.hpp"

namespace tetloom {

/// A triangle on which a size is asked for; a segment (b == c) or a point (a == b == c) as well.
struct SizeSource {
  Vec3 a, b, c;
  double size = 0;
};

/// Squared distance from `x` to the triangle a b c, which may be degenerate.
double squared_distance_to_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c);

/// The exact gradation-limited field of a set of sources,
///
///     f(x) = min over sources of  s + g max(0, |x - source| - s/2),
///
/// the largest field of slope g that is at most s within half an edge length of each source. The minimum is found by
/// branch and bound, as a nearest neighbour with additive weights.
///
/// Laws: |f(x) - f(y)| <= g |x - y|; f depends on the set of sources, not on their order, up to rounding.
/// Thread safety: immutable after construction.
class SourceTree {
 public:
  static constexpr std::uint32_t kNoSource = 0xffffffffu;

  /// Pre: 0 < gradation <= 1; sizes positive.
  SourceTree(std::vector<SizeSource> sources, double gradation, const TaskRunner& runner);

  bool empty() const { return sources_.empty(); }
  double smallest() const { return node_sizes_.empty() ? HUGE_VAL : node_sizes_[0]; }
  double source_size(std::uint32_t source) const { return sources_[source].size; }

  /// min(f(x), cap). `winner` speeds the search up when it comes in as the winner at a nearby point; it goes out as the
  /// source that decides, or kNoSource where the cap does.
  double size_at(const Vec3& x, double cap, std::uint32_t& winner) const;

 private:
  static constexpr double kHold = 0.5;  ///< how far a source's size holds before it grows, in sizes

  double gradation_;
  std::vector<SizeSource> sources_;  ///< in the order of the hierarchy
  Bvh bvh_;
  std::vector<double> node_sizes_;  ///< the smallest size below each node
};

}  // namespace tetloom
