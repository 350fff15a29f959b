#pragma once
// Where something lies in the mesh that adaptation starts from.
#include <array>
#include <cstdint>

#include "tetloom/ids.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {

/// A place in a background mesh: a tet and barycentric coordinates in it.
struct BackgroundPlace {
  std::uint32_t tet = kNone;
  std::array<double, 4> weights{};  ///< not negative, sum 1 up to round-off
};

/// The mean there of what the corners of its tet have.
template <class Values, class Corners>
Tensor mean_of_corners(const Values& values, const BackgroundPlace& place, const Corners& corners) {
  Tensor sum = place.weights[0] * values[corners[0]];
  for (std::size_t i = 1; i < 4; ++i) sum += place.weights[i] * values[corners[i]];
  return sum;
}

}  // namespace tetloom::adapt
