#pragma once
// Size fields.
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tetloom/vec.hpp"

// The flat arrays of a size field's octree, as its builder fills them and as they travel between processes.

namespace tetloom {

/// An octree over the cube [origin, origin + width]³. Cells come in blocks of 8 children: cell 8 b + o is octant o (bit
/// 0: x, 1: y, 2: z) of block b, and block 0 holds the children of the root. What a cell is, its code says:
///
///     code < kLeafBit        the block of its children
///     kLeafBit + i           a leaf with sizes of its own at its corners; those of its block begin at corner_ratios[i]
///     kGlobalLeaf            a leaf on which the size is `size` throughout
///
/// The sizes at the corners of a block's leaves, in shares of `size`, stand in corner_ratios once each, along x, then
/// y, then z; blocks follow each other in their order. `set_corner_ratios` puts them there.
///
/// Invariants (`validate_octree`): blocks are in depth-first order, so a child block follows its parent and every block
/// but the first has exactly one parent; each block has the ratios of its leaves and no others; ratios lie in (0, 1];
/// no cell lies deeper than kMaxDepth. Neighbours of a leaf are at most one level coarser when the builder balanced the
/// tree, which is not required for reading it.
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
  std::vector<float> corner_ratios;
};

/// Gives the leaves of a tree their sizes: those with the code kLeafBit + i have the ratios leaf_to_ratios[i] at their
/// corners, in the order of octants, and get the codes that a SizeOctree has. Where two leaves of a block have
/// different ones at a common corner the smaller holds. Throws Error(InvalidArgument) where a leaf has none.
void set_corner_ratios(SizeOctree& tree, std::span<const std::array<float, 8>> leaf_to_ratios);

/// What is wrong with a tree, in one sentence; empty when nothing is.
std::string validate_octree(const SizeOctree& tree);

// The target edge length at every point of space.

/// A leaf of the octree, or of its part inside a box.
struct SizeLeaf {
  Box3 box;
  double size = 0;  ///< at the centre of `box`
};

/// A size field: either one size everywhere or an immutable octree with sizes at the corners of its leaves, between
/// which it is trilinear. Where no smaller size applies it answers the global size exactly, bit for bit.
///
/// The field is continuous inside leaves and across leaves of one level; between leaves of different levels it may
/// jump by the error of the interpolation, which the builder keeps within a few percent.
///
/// Thread safety: immutable; copies share the arrays. Any number of threads may read one field or copies of it.
class SizeField {
 public:
  /// The same size everywhere. Pre: size > 0 and finite; otherwise throws Error(InvalidArgument).
  static SizeField uniform(double size);

  /// Takes over a tree. Throws Error(InvalidArgument) when it breaks an invariant of SizeOctree.
  static SizeField from_octree(SizeOctree tree);

  /// Target edge length at `x` (model length), > 0; defined in the whole space: outside the tree's domain it grows
  /// from the nearest point of the domain by the gradation, up to the global size. Wait-free, allocates nothing, may be
  /// called by any number of threads. Complexity: the depth of the tree less 4 to 6.
  double size_at(const Vec3& x) const;

  /// The smallest and largest size that the field holds.
  double smallest() const { return smallest_; }
  double largest() const { return largest_; }

  /// The largest growth of the size per unit of distance that the builder allowed; 0 for a uniform field.
  double gradation() const { return gradation_; }

  bool is_uniform() const { return tree_ == nullptr; }
  std::size_t leaf_count() const;
  /// Bytes that the field holds, whatever the number of its copies.
  std::size_t memory() const;

  /// The same field, whose arrays lie where `keep` puts a copy of their bytes, as long as this or a copy of it holds
  /// that; those for which it returns null stay. So several processes can have one copy of what all of them look at.
  SizeField kept_by(const std::function<std::shared_ptr<const std::byte>(std::span<const std::byte>)>& keep) const;

  /// Calls `visit` for every leaf that meets `box`, in Morton order, clipped to the box. A uniform field has one leaf,
  /// the box itself. Leaves outside the domain carry the global size.
  void for_each_leaf(const Box3& box, const std::function<void(const SizeLeaf&)>& visit) const;

  /// The integral of tets_per_cube / size³ over `box`: how many tetrahedra it would take to fill it.
  double estimate_tets(const Box3& box) const;

 private:
  class Tree;
  double smallest_ = 0, largest_ = 0, gradation_ = 0;
  std::shared_ptr<const Tree> tree_;
};

/// Tetrahedra per size³ in a good mesh whose mean edge is the size (a body-centred lattice with that mean edge).
inline constexpr double kTetsPerCube = 9.3;
/// Equilateral triangles per size².
inline constexpr double kTrianglesPerSquare = 2.3094010767585034;

}  // namespace tetloom
