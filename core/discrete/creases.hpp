#pragma once
// Which sharp edges of a facet surface are creases of the shape and which are noise. Private to core/discrete.
#include <vector>

#include "core/discrete/facet_surface.hpp"

namespace tetloom::detail {

/// Facet edges that faces may not be walked across: those that are no joints or lie between groups, and the creases,
/// which turn by more than the feature angle. Of the creases are left out: groups of few short edges, branches of few
/// short edges that end within a face, and what bounds a face of few facets too small to matter (0.3 % of the box's
/// diagonal wide, 1 % where no crease at it is sharper than 60°), so that the noise of a scan does not cut it to
/// pieces. Creases that fade out within a face are kept otherwise: the face has them on both sides.
///
/// Deterministic. Complexity: O(n log n).
std::vector<bool> find_walls(const FacetSurface& surface, double feature_angle);

/// For each facet the set of facets that can be reached without crossing a wall; sets are numbered by their first
/// facet.
std::vector<std::uint32_t> flood_between_walls(const FacetSurface& surface, const std::vector<bool>& walls,
                                               std::uint32_t& count);

}  // namespace tetloom::detail
