#pragma once
// Where something lies in the mesh that adaptation starts from.
#include <array>
#include <cstdint>

#include "core/spatial/distances.hpp"
#include "tetloom/ids.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {

/// The name of a tet of the mesh that adaptation starts from. In a mesh in one piece: its place there. In tiles: see
/// Tile; no rank need have the whole then, so names have 64 bits.
using BackgroundTet = std::uint64_t;
inline constexpr BackgroundTet kNoTet = ~BackgroundTet{0};

/// One of its faces, as tets::FaceCode.
class BackgroundFace {
 public:
  BackgroundFace() = default;
  BackgroundFace(BackgroundTet tet, std::uint32_t side) : code_(tet * 4 + side) {}
  bool valid() const { return code_ != kNoTet; }
  BackgroundTet tet() const { return code_ / 4; }
  std::uint32_t side() const { return static_cast<std::uint32_t>(code_ % 4); }

 private:
  std::uint64_t code_ = kNoTet;
};

/// The nearest point of the boundary of that mesh.
struct NearestOnBoundary {
  BackgroundFace face;  ///< not valid: nothing is within reach
  TrianglePoint point;
};

/// A place in a background mesh: a tet and barycentric coordinates in it.
struct BackgroundPlace {
  BackgroundTet tet = kNoTet;
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
