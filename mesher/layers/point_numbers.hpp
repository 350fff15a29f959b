#pragma once
// The numbers of points in a mesh of layers and volume.
#include <cstdint>
#include <vector>

#include "mesher/layers/stack_elements.hpp"

namespace tetloom::layers {

/// Points are numbered twice. As they are made: those of the growth's surface, those that filling adds, then the points
/// of curves between foot and top, curve by curve. In the mesh: the same without points that nothing has, such as
/// those where a side face was meshed anew; points of model vertices stay.
class PointNumbers {
 public:
  /// `after_volume`: one past the last point that filling added. Refers to `growth`.
  PointNumbers(const LayerGrowth& growth, std::uint64_t after_volume);

  std::uint64_t surface_points() const { return surface_.size(); }
  std::uint64_t first_level_point() const { return first_level_point_; }
  std::uint64_t count() const { return first_level_point_ + levels_before_.back(); }  ///< as they are made
  std::uint64_t dropped() const { return dropped_; }

  /// The point of a curve, as it was made.
  std::uint64_t made(const CurveLevel& at) const {
    if (at.level == 0) return growth_.walls().curve_to_vert[at.curve];
    if (at.level == growth_.counts().count(at.curve)) return growth_.surface().curve_to_top[at.curve];
    return first_level_point_ + levels_before_[at.curve] + static_cast<std::uint64_t>(at.level) - 1;
  }
  /// Its number in the mesh. Pre: the mesh has it.
  std::uint64_t in_mesh(std::uint64_t made) const { return made < surface_.size() ? surface_[made] : made - dropped_; }
  /// All points of a curve in the mesh.
  CurveVertices curve_in_mesh(std::uint32_t curve) const {
    const auto number = [&](int level) { return static_cast<std::uint32_t>(in_mesh(made({curve, level}))); };
    const std::uint64_t first = in_mesh(first_level_point_ + levels_before_[curve]);
    return {number(0), number(growth_.counts().count(curve)), static_cast<std::uint32_t>(first)};
  }
  /// The apex of a stack in the mesh, or none.
  std::uint32_t apex_in_mesh(std::uint32_t stack) const {
    const std::uint64_t made = made_apex(stack);
    return made == kNone ? kNone : static_cast<std::uint32_t>(in_mesh(made));
  }
  /// The same as it was made.
  std::uint32_t made_apex(std::uint32_t stack) const {
    const Walls& walls = growth_.walls();
    return walls.is_fan(stack) ? growth_.surface().fan_to_apex[stack - walls.triangles.size()] : kNone;
  }
  bool is_used(std::uint64_t made) const { return made >= surface_.size() || surface_[made] != kNone; }
  /// The curve of a point between foot and top.
  std::uint32_t curve_of(std::uint64_t made) const;

 private:
  void number_surface();

  const LayerGrowth& growth_;
  std::vector<std::uint32_t> surface_;        // in the mesh, of each point of the surface; kNone: nothing has it
  std::vector<std::uint64_t> levels_before_;  // points of curves with lower numbers; one longer than there are curves
  std::uint64_t first_level_point_ = 0, dropped_ = 0;
};

}  // namespace tetloom::layers
