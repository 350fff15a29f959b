#pragma once
// The read side of a size field's octree. Private to core/sizing.
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/base/fixed_array.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom {

/// A valid SizeOctree with a table that skips the first levels of every descent.
class SizeField::Tree {
 public:
  /// Pre: validate_octree(octree) finds nothing.
  explicit Tree(SizeOctree octree);

  double size_at(const Vec3& x) const;
  void for_each_leaf(const Box3& box, const std::function<void(const SizeLeaf&)>& visit) const;
  std::size_t leaf_count() const;
  std::size_t memory() const;
  void move_arrays(const KeepBytes& keep);

 private:
  static constexpr int kMaxDepth = SizeOctree::kMaxDepth;
  static constexpr std::uint32_t kCells = 1u << kMaxDepth;  ///< finest cells along an axis

  /// Where a descent starts: a node at top_depth_, or a leaf above it.
  struct TopCell {
    std::uint32_t code = 0;  ///< of a leaf with sizes kLeafBit + its cell
    std::uint32_t depth = 0;
  };

  void fill_top(std::uint32_t block, std::uint32_t depth, const std::array<std::uint32_t, 3>& corner,
                std::vector<TopCell>& top) const;
  double interpolate(std::size_t cell, double x, double y, double z) const;

  SizeOctree frame_;  ///< without its arrays
  FixedArray<std::uint32_t> cells_;
  FixedArray<float> corner_ratios_;
  std::uint32_t top_depth_ = 0;  ///< deep enough to save steps, not so deep that the table leaves the cache
  double scale_ = 0;             ///< finest cells per unit of length
  FixedArray<TopCell> top_;
};

}  // namespace tetloom
