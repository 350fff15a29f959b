#pragma once
// Facets as they come from a file, before they are a surface: what the readers make and the cleaning works on.
// Private to core/discrete.
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tetloom/host.hpp"
#include "tetloom/model.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::detail {

/// A facet by its three points.
using Triangle = std::array<std::uint32_t, 3>;

/// Triangles over points, in any state: repeated points, holes, any orientation. `tri_to_group` is as long as
/// `tri_to_vert`, or empty when there is one group; its values index `group_names`.
struct FacetSoup {
  std::vector<Vec3> points;
  std::vector<Triangle> tri_to_vert;
  std::vector<std::uint32_t> tri_to_group;
  std::vector<std::string> group_names;
  std::vector<std::string> remarks;  ///< what the reader noticed and the user should know

  std::uint32_t group(std::size_t tri) const { return tri_to_group.empty() ? 0 : tri_to_group[tri]; }
};

/// Removes facets with a repeated point; returns how many.
std::size_t remove_collapsed(FacetSoup& soup);

/// Parses an STL file, ASCII or binary by content; each solid of an ASCII file is a group. `name` is for messages.
/// Errors: InputUnreadable (neither format, truncated), Cancelled.
FacetSoup parse_stl(std::string_view bytes, const std::string& name, const CancelToken* cancel);

/// Parses a Wavefront OBJ file: `v`, `f` (polygons are triangulated), `g` and `o` as groups; all else is skipped.
/// Errors: InputUnreadable (no OBJ file, broken line, index out of range), Cancelled.
FacetSoup parse_obj(std::string_view bytes, const std::string& name, const CancelToken* cancel);

/// Turns a soup into a set of proper facets: equal points merged; facets with repeated points, duplicate facets and
/// facets thinner than single-precision resolution removed; cracks between points closed where a small tolerance
/// (at most 1e-4 of the bounding box's diagonal) closes them, T-junctions cut, needles collapsed, and holes up to
/// `hole_width` wide filled. Unused points are dropped. Returns what was repaired.
/// Errors: InputUnsuitable (coordinates that are not finite or absurd, no facets left), Cancelled.
std::vector<HealingStep> clean_soup(FacetSoup& soup, double hole_width, const CancelToken* cancel);

inline void check_cancelled(const CancelToken* cancel) {
  if (cancel) cancel->check();
}

}  // namespace tetloom::detail
