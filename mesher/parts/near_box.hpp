#pragma once
// What a part tells of to those parts alone that lie near it.
#include <span>
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

/// What a part of this box is told of, in the order of `placed`.
template <class What>
std::vector<What> near_box(const std::vector<Placed<What>>& placed, const Box3& box) {
  std::vector<What> near;
  for (const Placed<What>& one : placed)
    if (distance_outside(one.place, box) <= one.reach) near.push_back(one.what);
  return near;
}

}  // namespace tetloom::parts
