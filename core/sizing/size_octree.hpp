#pragma once
// The flat arrays of a size field's octree, as its builder fills them and as they travel between processes.
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/vec.hpp"

namespace tetloom {

/// An octree over the cube [origin, origin + width]³. Cells come in blocks of 8 children: cell 8 b + o is octant o (bit
/// 0: x, 1: y, 2: z) of block b, and block 0 holds the children of the root. What a cell is, its code says:
///
///     code < kLeafBit        the block of its children
///     kLeafBit + i           a leaf whose corners have the sizes size * corner_ratios[i][o]
///     kGlobalLeaf            a leaf on which the size is `size` throughout
///
/// Invariants (`validate_octree`): blocks are in depth-first order, so a child block follows its parent and every block
/// but the first has exactly one parent; corner_ratios are in Morton order, one per leaf that refers to them; ratios
/// lie in (0, 1]; no cell lies deeper than kMaxDepth. Neighbours of a leaf are at most one level coarser when the
/// builder balanced the tree, which is not required for reading it.
struct SizeOctree {
  static constexpr int kMaxDepth = 20;
  static constexpr std::uint32_t kLeafBit = 0x80000000u;
  static constexpr std::uint32_t kGlobalLeaf = 0xffffffffu;

  Vec3 origin;
  double width = 0;
  Box3 domain;           ///< within the cube; the field is resolved here, and grown from its border elsewhere
  double size = 0;       ///< the largest size, model length
  double gradation = 0;  ///< growth of the size per unit of distance outside `domain`
  std::vector<std::uint32_t> cells;
  std::vector<std::array<float, 8>> corner_ratios;
};

/// What is wrong with a tree, in one sentence; empty when nothing is.
std::string validate_octree(const SizeOctree& tree);

}  // namespace tetloom
