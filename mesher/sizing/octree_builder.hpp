#pragma once
// A linear octree, level by level, balanced, and packed into the flat arrays of a SizeField. Private to mesher/sizing.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/sizing/target_field.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// A block of a tree's cells of which some are leaves that need sizes at their corners.
struct OctreeBlock {
  std::uint32_t first_cell;             ///< in SizeOctree::cells
  std::array<std::uint32_t, 3> corner;  ///< in cells of SizeOctree::kMaxDepth
  std::uint32_t width;                  ///< of one of its cells, in the same unit
};

/// The cube that all cells are halves of.
struct OctreeFrame {
  Vec3 origin;
  double width = 0;
};

/// A cube around `domain` whose halves have widths that suit the sizes of most sources: of the fractions of a power of
/// two, the one that needs the fewest leaves beside the sources. `width_at_source`: of the widest leaves, in sizes.
OctreeFrame fit_frame(const Box3& domain, std::span<const SizeSource> sources, double width_at_source);

/// A cell that was judged.
struct OctreeCell {
  std::uint64_t code;  ///< Morton code at the level of the cell
  JudgedCell judged;
};
/// Which of `ranks` looks at a place whose Morton code has `depth` octants: the same for all places in a cell of depth
/// kRankDepth, in every build in the same frame.
inline int rank_at(std::uint64_t code, int depth, int ranks) {
  constexpr int kRankDepth = 6;
  constexpr std::uint64_t kSpread = 0x9e3779b97f4a7c15ull;
  const std::uint64_t cell = depth > kRankDepth ? code >> 3 * (depth - kRankDepth) : code;
  return static_cast<int>((cell * kSpread >> 32) % static_cast<std::uint64_t>(ranks));
}

/// Cells by their levels, in the order of their codes: those that this rank looked at, and that have a least size of
/// their own.
using OctreeLevels = std::vector<std::vector<OctreeCell>>;

/// Cells are kept as Morton codes in sorted arrays, one per level: no hash, no pointers. Cells of a level are judged in
/// parallel and independently, by all ranks together; the tree is the same for any number of threads and ranks.
class OctreeBuilder {
 public:
  /// `domain`: cells outside of it are never cut. Throws Error(OutOfMemory) when the tree would exceed `max_cells`.
  OctreeBuilder(const TargetField& field, const OctreeFrame& frame, const Box3& domain, std::size_t max_cells,
                const SharedWork& work);

  /// The tree, but for its corner_ratios. `blocks` become those with leaves that need sizes, in the order of the tree.
  /// `before`: of a build with the same frame and without the field's latest refinements, or none. What the refinements
  /// do not lower is not judged again, and the tree is the same as without `before`. `levels` become those of this one.
  SizeOctree build(const OctreeLevels& before, OctreeLevels& levels, std::vector<OctreeBlock>& blocks);

 private:
  using Codes = std::vector<std::uint64_t>;
  /// What was judged of all cells of a level.
  struct JudgedLevel {
    Codes cuts;                         ///< of cells to be cut, ascending
    std::vector<CellVerdict> verdicts;  ///< of each child of the level above's cuts, in their order
  };
  struct PlacedCell {
    std::uint64_t code;
    CellVerdict verdict;
  };
  using PlacedLevels = std::vector<std::vector<PlacedCell>>;

  void judge(std::vector<OctreeCell>& cells, int level, std::span<const OctreeCell> before) const;
  std::vector<OctreeCell> own_cells(const std::vector<OctreeCell>& cells, int level) const;
  JudgedLevel verdicts_on(const std::vector<OctreeCell>& cells) const;
  Codes cuts_of(const std::vector<OctreeCell>& cells) const;
  std::vector<OctreeCell> children_of(const std::vector<OctreeCell>& cells, const Codes& cuts) const;
  void append_parents(int level, const Codes& cuts, Codes& coarser) const;
  void balance(std::vector<Codes>& cuts) const;
  PlacedLevels place(const std::vector<JudgedLevel>& levels, const std::vector<Codes>& cuts) const;
  SizeOctree pack(const PlacedLevels& levels, std::vector<OctreeBlock>& blocks) const;
  Box3 box_of(std::uint64_t code, int level) const;

  const TargetField& field_;
  OctreeFrame frame_;
  Box3 domain_;
  std::size_t max_cells_;
  const SharedWork& work_;
  const TaskRunner& runner_;
};

}  // namespace tetloom
