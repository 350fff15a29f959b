#pragma once
// Points at which a surface touches itself. Private to core/discrete.
#include <cstdint>
#include <vector>

#include "core/discrete/facet_surface.hpp"

namespace tetloom::detail {

/// The points around which the facets are not one fan but several, one of them all around the point, as where two tips
/// touch; ascending.
std::vector<std::uint32_t> find_pinched_points(const FacetSurface& surface);

/// Adds walls so that pinched points lie on the rim of a face in each of their fans: in a fan without any, one or two
/// edges that begin at the point. Linear.
void add_walls_at(const std::vector<std::uint32_t>& pinched_points, const FacetSurface& surface,
                  std::vector<bool>& walls);

}  // namespace tetloom::detail
