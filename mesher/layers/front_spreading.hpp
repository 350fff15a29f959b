#pragma once
// Where the front of layers shrinks, as at concave edges, or grows, as at convex ones, its points are spread over it.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/layers/growth_direction.hpp"
#include "mesher/layers/walls.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// A front before it is spread, per curve.
struct ChangingFront {
  std::span<const Vec3> points;
  std::span<const std::uint8_t> is_free;  ///< may be moved within the front
  std::span<const FrontFreedom> freedom;
  std::span<const double> most;  ///< how far it may be moved
};

/// Refers to the walls.
class FrontSpreading {
 public:
  /// `feet` are the points of all curves on the walls.
  FrontSpreading(const Walls& walls, std::span<const Vec3> feet);

  /// How far each point is to be moved within the front so that ways from the wall vary evenly: sweeps of the harmonic
  /// map (Pinkall & Polthier 1993) over the places where the front is smaller or larger than its wall. Its weights
  /// keep a front as it is that shrinks evenly, as in a pipe. The result depends on the arguments alone.
  std::vector<Vec3> find_shifts(const ChangingFront& front, const TaskRunner& runner) const;

 private:
  template <class Visit>
  void for_each_neighbour(std::uint32_t curve, const Visit& visit) const;
  Vec3 way(const ChangingFront& front, std::uint32_t curve) const { return front.points[curve] - feet_[curve]; }
  bool changes_at(const ChangingFront& front, std::uint32_t curve) const;
  Vec3 shift_at(const ChangingFront& front, const std::vector<Vec3>& shifts, std::uint32_t curve) const;

  const Walls& walls_;
  std::vector<Vec3> feet_;
  std::vector<std::array<float, 3>> weights_;  // per wall triangle and corner: cotangents of the angles
};

}  // namespace tetloom::layers
