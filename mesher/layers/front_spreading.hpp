#pragma once
// Where the front of layers shrinks, as at concave edges, or grows, as at convex ones, its points are spread over it.
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

  /// The other curves of the wall triangles at a curve, two for each triangle.
  struct Neighbour {
    std::uint32_t curve = 0;
    float weight = 0;  ///< cotangent of the angle that is opposite in the triangle
  };
  std::span<const Neighbour> neighbours_of(std::uint32_t curve) const {
    const std::size_t begin = walls_.curve_begin[curve], end = walls_.curve_begin[curve + 1];
    return std::span(neighbours_).subspan(2 * begin, 2 * (end - begin));
  }

 private:
  bool changes_at(std::span<const Vec3> ways, std::uint32_t curve) const;
  Vec3 shift_at(const ChangingFront& front, const std::vector<Vec3>& ways, const std::vector<Vec3>& shifted,
                std::uint32_t curve) const;

  const Walls& walls_;
  std::vector<Vec3> feet_;
  std::vector<Neighbour> neighbours_;  // of one curve after the other
};

}  // namespace tetloom::layers
