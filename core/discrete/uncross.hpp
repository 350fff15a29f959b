#pragma once
// The boundary of what a closed surface encloses that crosses itself. Private to core/discrete.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/discrete/facet_soup.hpp"

namespace tetloom::detail {

/// Facets without crossings, in place of those given.
struct UncrossedFacets {
  std::vector<Vec3> points;    ///< those given, some of them moved by a few 1e-9 of the diagonal at most, and others
  std::vector<Triangle> tris;  ///< oriented as before
  std::vector<std::uint32_t> tri_to_cut;  ///< the facet that each is a piece of, or is
};

/// How often the facets, seen as a closed surface with normals pointing outwards, wind around `point`, but for the
/// facet `left_out`: for a point on that one, the mean of both of its sides. Linear. After van Oosterom & Strackee,
/// "The solid angle of a plane triangle" (1983).
double winding_number(std::span<const Vec3> points, std::span<const Triangle> tris, const Vec3& point,
                      std::uint32_t left_out = 0xffffffffu);

/// Cuts facets where they cross, and leaves out the pieces that do not part what the surface winds around at least once
/// from what it does not: the self-union. Nothing where no facets cross, or where that cannot be told.
/// Pre: the facets are a closed surface, oriented outwards. Errors: Cancelled.
std::optional<UncrossedFacets> uncross_facets(std::span<const Vec3> points, std::span<const Triangle> tris,
                                              const CancelToken* cancel);

}  // namespace tetloom::detail
