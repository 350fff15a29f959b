#pragma once
// What a part tells of to those parts alone that lie near it.
#include <vector>

#include "mesher/parts/decomposition.hpp"

namespace tetloom::parts {

/// Something at a place, of which parts are told whose boxes are no farther than `reach`.
template <class What>
struct Placed {
  Vec3 place;
  double reach;
  What what;
};

/// Whether distance_outside(x, box) <= reach; most boxes are farther along the first axes already.
inline bool is_within(const Vec3& x, const Box3& box, double reach) {
  for (int axis = 0; axis < 3; ++axis)
    if (box.lo[axis] - x[axis] > reach || x[axis] - box.hi[axis] > reach) return false;
  return true;
}

/// The boxes of a part's neighbours, side by side.
class NeighborBoxes {
 public:
  NeighborBoxes(const Decomposition& decomposition, PartId part) {
    for (const PartId other : decomposition.neighbors(part)) boxes_.push_back(decomposition.box(other));
  }
  std::size_t size() const { return boxes_.size(); }
  /// Calls visit(i) for each neighbour i whose box is no farther than `reach`; ascending.
  template <class Visit>
  void for_each_near(const Vec3& place, double reach, Visit&& visit) const {
    for (std::size_t i = 0; i < boxes_.size(); ++i)
      if (is_within(place, boxes_[i], reach)) visit(i);
  }

 private:
  std::vector<Box3> boxes_;
};

/// What each neighbour of the part is told of, in the order of `placed`.
template <class What>
std::vector<std::vector<What>> near_neighbors(const std::vector<Placed<What>>& placed,
                                              const Decomposition& decomposition, PartId part) {
  const NeighborBoxes boxes(decomposition, part);
  std::vector<std::vector<What>> near(boxes.size());
  for (const Placed<What>& one : placed)
    boxes.for_each_near(one.place, one.reach, [&](std::size_t i) { near[i].push_back(one.what); });
  return near;
}

}  // namespace tetloom::parts
