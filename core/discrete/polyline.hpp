#pragma once
// The shape of a model edge of a discrete model. Private to core/discrete.
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::detail {

/// A model edge: a polyline over its arc length. Closed when its first and last points are the same.
struct Polyline {
  std::vector<Vec3> points;
  std::vector<double> lengths;  ///< from the start, one per point
  bool closed = false;
};

}  // namespace tetloom::detail
