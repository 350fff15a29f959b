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
  double hold = 0;  ///< how far the size holds before it grows; 0: a share of the size, by the kind of source
};

/// The exact gradation-limited field of a set of sources,
///
///     f(x) = min over sources of  s + g max(0, |x - source| - hold),
///
/// the largest field of slope g that is at most s within the hold of each source: by default 0.6 s for triangles, 0.75
/// s for segments and 0.95 s for points, as far as the interpolation in an octree leaf of width s looks away from them.
/// The minimum is found by branch and bound, as a nearest neighbour with additive weights.
///
/// Laws: |f(x) - f(y)| <= g |x - y|; f depends on the set of sources, not on their order, up to rounding.
/// Thread safety: immutable after construction.
class SourceTree {
 public:
  static constexpr std::uint32_t kNoSource = 0xffffffffu;

  /// Pre: gradation > 0; sizes positive.
  SourceTree(std::vector<SizeSource> sources, double gradation, const TaskRunner& runner);

  bool empty() const { return sources_.empty(); }
  double smallest() const { return bounds_.empty() ? HUGE_VAL : bounds_[0].size; }
  double source_size(std::uint32_t source) const { return sources_[source].size; }

  /// min(f(x), cap). `winner` speeds the search up when it comes in as the winner at a nearby point; it goes out as the
  /// source that decides, or kNoSource where the cap does.
  double size_at(const Vec3& x, double cap, std::uint32_t& winner) const { return least_within(x, 0, cap, winner); }

  /// The least that min(f, cap) comes to in the ball of `radius` around `x`, exactly; `winner` as above.
  double least_within(const Vec3& x, double radius, double cap, std::uint32_t& winner) const;

 private:
  /// A source made ready for distances.
  struct Triangle {
    Vec3 center;  ///< of a ball around it
    double radius = 0;
    Vec3 a, ab, ac;
    double ab2 = 0, ac2 = 0, abac = 0, area2 = 0;  ///< dot products; area2 is 0 for segments and points
    double size = 0, hold = 0;
  };

  /// The smallest size and the largest hold below a node.
  struct NodeBounds {
    double size = HUGE_VAL, hold = 0;
  };

  static Triangle prepare(const SizeSource& source);

  double gradation_;
  std::vector<Triangle> sources_;  ///< in the order of the hierarchy
  Bvh bvh_;
  std::vector<NodeBounds> bounds_;
};

}  // namespace tetloom
