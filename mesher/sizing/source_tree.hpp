#pragma once
// Where small sizes come from, and the size that they allow at any point. Private to mesher/sizing.
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/spatial/bvh.hpp"
#include "tetloom/tasks.hpp"
#include "tetloom/vec.hpp"

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
  double smallest() const { return smallest_; }
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

  /// Up to four subtrees side by side, so that the processor bounds them at once. Coordinates are seen from `origin_`;
  /// rounding makes boxes larger and sizes smaller.
  struct Node {
    static constexpr std::size_t kWidth = 4;
    static constexpr std::uint32_t kLeaf = 0x80000000u;
    using Lanes = float __attribute__((vector_size(kWidth * sizeof(float))));
    std::array<Lanes, 3> lo, hi;
    Lanes size;                               ///< the least below
    Lanes base;                               ///< the least that growth would begin from at distance 0
    std::array<std::uint32_t, kWidth> child;  ///< a node, or kLeaf | the first source
    std::array<std::uint32_t, kWidth> count;  ///< of the sources of a leaf
  };

  static Triangle prepare(const SizeSource& source);
  std::uint32_t add_node(const Bvh& bvh, std::uint32_t root);
  void set_child(Node& node, std::size_t place, const Bvh& bvh, std::uint32_t child) const;

  double gradation_;
  double smallest_ = HUGE_VAL;
  std::vector<Triangle> sources_;  ///< in the order of the hierarchy
  std::vector<Node> nodes_;        ///< the root comes first
  Vec3 origin_;
  float slack_ = 0;  ///< of distances, for rounding
};

}  // namespace tetloom
