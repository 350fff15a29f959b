#include "mesher/layers/point_numbers.hpp"

#include <algorithm>

namespace tetloom::layers {

PointNumbers::PointNumbers(const LayerGrowth& growth, std::uint64_t after_volume)
    : growth_(growth), first_level_point_(after_volume) {
  number_surface();
  const std::size_t curves = growth.walls().curve_count();
  levels_before_.reserve(curves + 1);
  levels_before_.push_back(0);
  for (std::uint32_t c = 0; c < curves; ++c)
    levels_before_.push_back(levels_before_.back() +
                             static_cast<std::uint64_t>(std::max(0, growth.counts().count(c) - 1)));
}

// Every point of a triangle that bounds a region is in a tet; feet below layers are in triangles that are covered, or
// bound the region on the other side.
void PointNumbers::number_surface() {
  const LayeredSurface& surface = growth_.surface();
  surface_.assign(surface.mesh.points.size(), kNone);
  const auto use = [&](const auto& elements) {
    for (const auto& element : elements)
      for (const std::uint32_t v : element) surface_[v] = 0;
  };
  use(surface.mesh.edge_to_vert), use(surface.mesh.tri_to_vert), use(surface.covered);
  for (std::uint32_t c = 0; c < growth_.walls().curve_count(); ++c)
    if (growth_.counts().count(c) > 0)
      surface_[surface.curve_to_top[c]] = surface_[growth_.walls().curve_to_vert[c]] = 0;
  std::uint32_t used = 0;
  for (std::size_t v = 0; v < surface_.size(); ++v)
    if (surface_[v] == 0 || surface.mesh.point_to_entity[v].dim == 0) surface_[v] = used++;
  dropped_ = surface_.size() - used;
}

std::uint32_t PointNumbers::curve_of(std::uint64_t made) const {
  const auto after = std::ranges::upper_bound(levels_before_, made - first_level_point_);
  return static_cast<std::uint32_t>(after - levels_before_.begin()) - 1;
}

}  // namespace tetloom::layers
