#pragma once
// The octree over which lattice points are chosen: cells of a few sizes, with the sites of each lattice in them.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/lattice/cell_sites.hpp"
#include "mesher/lattice/lattice_points.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::lattice {

/// One cell of the octree, inside the surface or met by it.
struct LatticeCell {
  Box3 box;
  double lo = 0, hi = 0;  ///< sizes met in it
  bool near_surface = false, meets_surface = false;
};

/// Any thread may ask it. Refers to the request.
class LatticeCells {
 public:
  /// Pre: the box of the request is not empty. Ranks share the work, and have the same cells afterwards. Errors:
  /// Cancelled; OutOfMemory when the field asks for more points than 32-bit ids can name.
  LatticeCells(const LatticeRequest& request, const SharedWork& work);
  /// At least so many are collected side by side, where there are so many.
  static constexpr std::size_t kSubtrees = 256;

  const std::vector<LatticeCell>& cells() const { return cells_; }
  /// Leaves all cells out but those with these indices, ascending.
  void keep(std::span<const std::uint32_t> cells);
  const std::vector<SiteLattice>& lattices() const { return lattices_; }  ///< finest first
  std::size_t level_count() const { return lattices_.size(); }
  /// The region that the surface names around x; kNone outside.
  std::uint32_t region_at(const Vec3& x) const;
  bool is_inside(const Vec3& x) const { return region_at(x) != kNone; }
  /// The coarsest lattice that may have sites in the cell.
  const SiteLattice& coarsest_of(const LatticeCell& cell) const;

  /// The sites of each level whose places without shift lie in `box`, which is in the cell. `sites` is working memory.
  std::vector<std::vector<KeptSite>> find_sites(const LatticeCell& cell, const Box3& box, CellSites& sites) const;

 private:
  struct Node {
    Box3 box;
    int depth;
    bool may_meet_surface;  // false: known to be inside
  };
  LatticeCell sized_cell(const Box3& box) const;
  template <class Leaf, class Branch>
  void visit(const Node& node, const Leaf& leaf, const Branch& branch) const;
  void collect(const Node& node, std::vector<LatticeCell>& cells) const;

  const LatticeRequest& request_;
  Levels levels_;
  std::vector<SiteLattice> lattices_;
  std::vector<LatticeCell> cells_;
};

/// Leaves out of `level` the sites nearer than about .65 of its size to `finer`: the points, as kept, of the lattices
/// up to kLevelsThatReach steps finer.
void drop_near_finer(LevelPoints& level, std::span<const std::span<const Vec3>> finer, const TaskRunner& runner);

/// How many finer levels reach a level's points.
inline constexpr std::size_t kLevelsThatReach = 3;

}  // namespace tetloom::lattice
