#pragma once
// The facets of one model face as a surface of its own. Private to core/discrete.
//
// Points are repeated where a model edge cuts through the face, so the facets are always a manifold whose boundary is
// the face's loops: a point for every fan of facets around a vertex.
#include <cstdint>
#include <vector>

#include "core/discrete/facet_bvh.hpp"
#include "core/discrete/facet_curvature.hpp"
#include "core/discrete/facet_surface.hpp"
#include "core/discrete/segmentation.hpp"

namespace tetloom::detail {

/// The facets of one face, with a tree over them.
struct FaceFacets {
  FaceFacets() = default;
  FaceFacets(const FaceFacets&) = delete;  // the tree refers to the arrays
  FaceFacets& operator=(const FaceFacets&) = delete;

  std::vector<Vec3> points;
  std::vector<Triangle> tri_to_vert;
  std::vector<std::uint32_t> vert_to_global;  ///< the point of the surface
  std::vector<std::uint32_t> vert_to_corner;  ///< 3·tri + corner of some facet at the point
  std::vector<bool> on_rim;
  PointJets jets;  ///< normals and bending of the points, from the facets of this face alone
  FacetBvh bvh;
};

/// Which facets each face has, ascending, and where each facet stands in its face.
struct FaceMembers {
  std::vector<std::uint32_t> offset, tris, tri_to_position;
  std::span<const std::uint32_t> of(std::uint32_t face) const {
    return std::span(tris).subspan(offset[face], offset[face + 1] - offset[face]);
  }
};

FaceMembers list_members(const Segmentation& segmentation);

/// Fills `result` for one face. Complexity: O(n log n) in the face's facets.
void collect_face(const FacetSurface& surface, const Segmentation& segmentation, const FaceMembers& members,
                  std::uint32_t face, FaceFacets& result);

}  // namespace tetloom::detail
