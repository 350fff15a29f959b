#pragma once
// A linear octree, level by level, balanced, and packed into the flat arrays of a SizeField. Private to mesher/sizing.
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/sizing/size_octree.hpp"
#include "mesher/sizing/target_field.hpp"
#include "threading/shared_work.hpp"

namespace tetloom {

/// A leaf that needs sizes at its corners.
struct OctreeLeaf {
  std::array<std::uint32_t, 3> corner;  ///< in cells of SizeOctree::kMaxDepth
  std::uint32_t width;                  ///< in the same unit
};

/// Cells are kept as Morton codes in sorted arrays, one per level: no hash, no pointers. Cells of a level are judged in
/// parallel and independently, by all ranks together; the tree is the same for any number of threads and ranks.
class OctreeBuilder {
 public:
  /// `domain`: cells outside of it are never cut. Throws Error(OutOfMemory) when the tree would exceed `max_cells`.
  OctreeBuilder(const TargetField& field, const Box3& domain, std::size_t max_cells, const SharedWork& work);

  /// The tree, with corner_ratios still to be filled: one entry per leaf of `leaves`, in the same (Morton) order.
  SizeOctree build(std::vector<OctreeLeaf>& leaves);

 private:
  struct Cell {
    std::uint64_t code;  ///< Morton code at the level of the cell
    CellState state;
    CellVerdict verdict;
  };

  std::vector<std::uint64_t> cuts_of(const std::vector<Cell>& cells) const;
  std::vector<Cell> children_of(const std::vector<Cell>& cells, const std::vector<std::uint64_t>& cuts) const;
  void append_parents(int level, std::vector<std::uint64_t>& coarser) const;
  void judge(std::vector<Cell>& cells, int level) const;
  void balance();
  void adopt_cuts();
  SizeOctree pack(std::vector<OctreeLeaf>& leaves) const;
  Box3 box_of(std::uint64_t code, int level) const;

  const TargetField& field_;
  Box3 domain_;
  std::size_t max_cells_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  Vec3 origin_;
  double width_ = 0;
  std::vector<std::vector<Cell>> levels_;         ///< every cell, sorted
  std::vector<std::vector<std::uint64_t>> cuts_;  ///< per level, the codes of the cells that are cut, sorted
};

}  // namespace tetloom
