#pragma once
// Which regions lie on the two sides of each leaf. Private to core/discrete.
//
// The facets cut space into cells. Around an edge, each facet's side belongs to the same cell as the side of the next
// facet that it looks at, so joining sides around all edges gives the *shells*: connected boundaries of cells, seen
// from inside the cell. Of a component (leaves connected through edges) one shell is seen from without and
// encloses negative volume; each other shell encloses a cell of its own.
//
//       front₁ │ back₁        Two facets on a joint share front and back; at an edge of one facet front and back are
//        ──────●──────        the same shell; at an edge of three or more the neighbours by angle face each other.
//       front₂   back₂
//
// Components lie in cells of other components. A cell holds material, that is, it is a region, when the number of
// components around its own one is even: a shell inside a solid is a void, a shell in that void is a solid again.
#include <cstdint>
#include <vector>

#include "core/discrete/facet_surface.hpp"
#include "tetloom/error.hpp"
#include "tetloom/model.hpp"

namespace tetloom::detail {

/// The regions of a facet surface.
struct FacetRegions {
  std::vector<FaceSides> leaf_to_sides;  ///< after turning the leaves in `turn` over
  std::vector<bool> turn;                ///< leaves whose single region would otherwise lie in front of them
  std::uint32_t region_count = 0;        ///< numbered by the first facet on each region's own shell
  std::vector<Diagnostic> warnings;
};

/// Errors: InputUnsuitable with a point where facets at an edge of three or more overlap so that no cells result.
FacetRegions find_regions(const FacetSurface& surface);

}  // namespace tetloom::detail
