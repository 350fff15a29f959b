#pragma once
// Cutting a facet surface into model faces, edges and vertices. Private to core/discrete.
//
// Faces are the largest sets of facets of one group and one leaf that can be walked without crossing a wall (see
// creases.hpp). Model edges are chains of walls: between different faces, at the rims of leaves, and within one face
// where a crease fades out in it; such an edge appears twice in the face, once in each direction. Model vertices lie
// where chains end, meet, change their faces or turn by more than the feature angle, and where the surface touches
// itself in a point, at which each fan of facets gets an edge; a closed chain without any gets one at its lowest point.
#include <cstdint>
#include <vector>

#include "core/discrete/facet_surface.hpp"
#include "tetloom/model.hpp"

namespace tetloom::detail {

/// The model faces, edges and vertices of a facet surface.
struct Segmentation {
  std::vector<std::uint32_t> tri_to_face;  ///< faces are numbered by their first facet
  std::uint32_t face_count = 0;
  std::vector<std::uint32_t> edge_to_model_edge;                ///< per facet edge; kNone within faces
  std::vector<std::vector<std::uint32_t>> model_edge_to_verts;  ///< points in order; closed: the first again at the end
  std::vector<std::uint32_t> model_vert_to_vert;                ///< ascending
  std::vector<std::uint32_t> vert_to_model_vert;                ///< kNone elsewhere
  std::vector<std::vector<ModelLoop>> face_to_loops;  ///< see tetloom/model.hpp; none for a face without edges
};

/// Pre: 0 < feature_angle. Deterministic; linear in the number of facets.
Segmentation segment_surface(const FacetSurface& surface, double feature_angle);

/// The half-edge on a model edge that follows `half`, itself on one, along the rim of its face: facets are on the left.
std::uint32_t next_rim_half(const FacetSurface& surface, const Segmentation& segmentation, std::uint32_t half);

}  // namespace tetloom::detail
