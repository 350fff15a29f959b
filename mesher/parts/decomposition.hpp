#pragma once
// Space cut into boxes, one per part, so that filling each takes about the same time.
//
// The work in every cell of the lattices' octree is estimated from the size field, that next to the surface and where
// the size varies apart from that in the lattice core, which is written in closed form. Planes bisect it, weighted by
// the work, the longest axis first (recursive coordinate bisection; Berger & Bokhari 1987). A plane runs between two
// planes of lattice sites: which side a site is on follows from its index.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/lattice/lattice_cells.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/tasks.hpp"
#include "tetloom/vec.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::parts {

/// What filling a volume will make and take.
struct VolumeEstimate {
  double tets = 0;  ///< within some ten percent
  double work = 0;  ///< microseconds of one thread
};

VolumeEstimate estimate_volume(const lattice::LatticeCells& cells);

/// In how many parts to fill it: of about `tets_per_part` tets each, and where that is 0, of about .4 s of work, but of
/// no more than 2.5e5 tets. At least 1.
std::size_t count_parts(const VolumeEstimate& volume, double tets_per_part);

/// Whether one part is all that there will be, whatever the sizes inside, by a rough estimate of the tets alone: for a
/// complex that is not worth looking at by all ranks. No does not say that there will be several.
bool is_one_part(double tets, std::size_t triangles, double tets_per_part);

/// Immutable; but for the cells of parts, the same on all ranks. All of space belongs to some part: outer boxes are
/// infinite.
class Decomposition {
 public:
  /// Pre: part_count > 0. `trace` may be null. Ranks share the work, and all know all.
  Decomposition(const lattice::LatticeCells& cells, std::size_t part_count, const SharedWork& work,
                Trace* trace = nullptr);

  std::size_t part_count() const { return boxes_.size(); }
  const Box3& box(PartId part) const { return boxes_[part.value]; }
  PartId owner_of(const Vec3& x) const;
  /// Estimated, in microseconds.
  double work(PartId part) const { return work_[part.value]; }
  /// Indices of the cells that reach into the part's box, ascending. Of the parts of this rank.
  std::span<const std::uint32_t> cells_of(PartId part) const { return part_to_cells_[part.value]; }
  /// Leaves the cells of all other parts out. Those that stay, of which it returns the indices, ascending, get the
  /// numbers from 0 on.
  std::vector<std::uint32_t> keep_cells_of(std::span<const PartId> parts);
  /// Parts with anything within kNeighborhood sizes, ascending; symmetric.
  std::span<const PartId> neighbors(PartId part) const { return part_to_neighbors_[part.value]; }
  /// Calls visit(part) for every part whose box overlaps `box`, ascending in the tree.
  template <class Visit>
  void for_each_in(const Box3& box, Visit&& visit) const {
    descend(0, box, visit);
  }

  /// How far parts look at each other in any step, in sizes.
  static constexpr double kNeighborhood = 8;

 private:
  static constexpr int kLeaf = -1, kNotCut = -2;  // the latter where a rank has no part
  struct Node {
    int axis = kNotCut;  // kLeaf: none
    double at = 0;
    std::uint32_t low = 0, high = 0;  // children; low: the part of a leaf
  };
  struct Piece {
    Box3 box;
    double work;
    std::uint32_t cell;
  };

  /// A node and what lies below it.
  struct Branch {
    std::uint32_t node = 0, first_part = 0, part_count = 0;
  };

  void bisect(std::vector<Piece> pieces, const Box3& box, const Branch& branch, std::span<const PartId> own);
  void share_cuts(const SharedWork& work);
  void find_neighbors(const lattice::LatticeCells& cells, const SharedWork& work);
  template <class Visit>
  void descend(std::uint32_t index, const Box3& box, Visit&& visit) const {
    const Node& node = nodes_[index];
    if (node.axis < 0) return visit(PartId(node.low));
    if (box.lo[node.axis] < node.at) descend(node.low, box, visit);
    if (box.hi[node.axis] >= node.at) descend(node.high, box, visit);
  }

  std::vector<Node> nodes_;
  std::vector<Box3> boxes_;
  std::vector<double> work_;
  std::vector<std::vector<std::uint32_t>> part_to_cells_;
  std::vector<std::vector<PartId>> part_to_neighbors_;
};

/// How far x lies outside of the box along the axis where that is farthest; 0 inside.
inline double distance_outside(const Vec3& x, const Box3& box) {
  double distance = 0;
  for (int axis = 0; axis < 3; ++axis) distance = std::max({distance, box.lo[axis] - x[axis], x[axis] - box.hi[axis]});
  return distance;
}

/// How far x lies from the nearest of the box's sides: no other part's box is nearer. Less than 0 outside.
inline double depth_inside(const Vec3& x, const Box3& box) {
  double depth = HUGE_VAL;
  for (int axis = 0; axis < 3; ++axis) depth = std::min({depth, x[axis] - box.lo[axis], box.hi[axis] - x[axis]});
  return depth;
}

}  // namespace tetloom::parts
