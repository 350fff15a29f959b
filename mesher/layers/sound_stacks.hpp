#pragma once
// How far up the cells above a wall triangle are good enough, for solvers and for the tets on top of them.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "mesher/layers/stack_cells.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// What cells have to be, per wall triangle. Refers to the walls.
///
/// All are positive in exact arithmetic, however they are split. The first layer has a scaled Jacobian of .02 at least;
/// further ones have .25, where no more is asked of them, or .8 of what the first one has where that is less. Fronts
/// that are narrower than the wall keep all angles above 15 degrees where the wall is flat or has a sharp edge, and
/// above 23 degrees where it bends: there a tet that lies over two narrow triangles at an angle of nearly 180 degrees
/// is flat, and no other tets can take its place. Above narrow wall triangles .8 of the sine suffices.
class SoundStacks {
 public:
  static constexpr double kLeastAbove = 0.25;  ///< scaled Jacobian of layers but the first

  /// `feet` are the points of all curves on the walls. Errors: Cancelled.
  SoundStacks(const Walls& walls, std::span<const Vec3> feet, const TaskRunner& runner);

  /// How many levels of cells are sound, from the wall on; the highest of the counts where all are. point(curve, level)
  /// is asked for levels from 0 to count_of(curve), and with no curve for the apex of a stack. Layers but the first
  /// have a scaled Jacobian of `least`.
  template <class CountOf, class PointAt>
  int levels(std::uint32_t stack, const CountOf& count_of, const PointAt& point, double least = kLeastAbove) const;
  /// What is asked of cells above a first layer of this scaled Jacobian, where `least` is asked of others.
  static double least_above(double least, double jacobian_of_first);
  /// Whether a cell of a stack may be as flat as its layer: in the first one; of those on edges, lying prisms and what
  /// ends a stack.
  bool may_be_flat(std::uint32_t stack, int layer, std::size_t vertices) const {
    return layer == 1 || (walls_.curves_of(stack).size() == 4 && vertices != 8);
  }

 private:
  struct Limits {
    float width = 0, sine = 0;  // fronts narrower than that have this sine at least
  };
  static constexpr double kLeastFirst = 0.02;

  Limits limits_of(std::uint32_t wall, std::span<const Vec3> feet, std::span<const Vec3> normals) const;
  bool is_bent_at(std::uint32_t wall, std::span<const Vec3> normals) const;
  bool is_wide_enough(std::uint32_t wall, const std::array<Vec3, 3>& front) const;
  template <class CountOf, class PointAt>
  bool is_wide_enough(std::uint32_t stack, int layer, const CountOf& count_of, const PointAt& point) const;

  const Walls& walls_;
  std::vector<Limits> limits_;  // per wall triangle
};

template <class CountOf, class PointAt>
int SoundStacks::levels(std::uint32_t stack, const CountOf& count_of, const PointAt& point, double least) const {
  int highest = 0;
  for (const std::uint32_t c : walls_.curves_of(stack)) highest = std::max(highest, count_of(c));
  int sound = highest;
  double above = 1;  // of layers but the first
  for_each_cell_on(walls_, stack, count_of, [&](const auto& cell, int layer) {
    if (std::min(layer, highest) > sound) return;
    std::array<Vec3, std::tuple_size_v<std::decay_t<decltype(cell)>>> x;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = point(cell[i].curve, cell[i].level);
    const bool is_good = is_sound(x, may_be_flat(stack, layer, x.size()) ? kLeastFirst : above) &&
                         (layer == 1 || is_wide_enough(stack, layer, count_of, point));
    if (layer == 1 && is_good) above = std::min(above, least_above(least, scaled_jacobian(x)));
    if (!is_good) sound = std::min(layer, highest) - 1;
  });
  return sound;
}

template <class CountOf, class PointAt>
bool SoundStacks::is_wide_enough(std::uint32_t stack, int layer, const CountOf& count_of, const PointAt& point) const {
  if (walls_.is_fan(stack)) return true;
  std::array<Vec3, 3> front;
  const auto& curves = walls_.triangles[stack].curves;
  for (std::size_t i = 0; i < 3; ++i) front[i] = point(curves[i], std::min(layer, count_of(curves[i])));
  return is_wide_enough(stack, front);
}

}  // namespace tetloom::layers
