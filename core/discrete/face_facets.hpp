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
#include "tetloom/ids.hpp"
#include "tetloom/storage.hpp"

namespace tetloom::detail {

/// The facets of one face, with a tree over them.
struct FaceFacets {
  FaceFacets() = default;
  FaceFacets(const FaceFacets&) = delete;  // the tree refers to the arrays
  FaceFacets& operator=(const FaceFacets&) = delete;

  std::vector<Vec3> points;
  std::vector<Triangle> tri_to_vert;
  std::vector<std::uint32_t> vert_to_corner;  ///< 3·tri + corner of some facet at the point
  std::vector<ModelEntity> vert_to_entity;
  std::vector<double> vert_to_parameter;  ///< on the model edge; 0 of other points
  PointJets jets;                         ///< normals and bending of the points, from the facets of this face alone
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

/// For each point of the surface the model edge that has it inside of it, or kNone, and the arc length there.
struct PlacesOnEdges {
  std::vector<std::uint32_t> vert_to_model_edge;
  std::vector<double> vert_to_parameter;
};

/// Fills `result` for one face. Complexity: O(n log n) in the face's facets.
void collect_face(const FacetSurface& surface, const Segmentation& segmentation, const FaceMembers& members,
                  const PlacesOnEdges& on_edges, std::uint32_t face, FaceFacets& result);

/// All but the tree, which `get_facets` makes anew.
void put_facets(MessageWriter& writer, const FaceFacets& facets);
void get_facets(MessageReader& reader, FaceFacets& facets);

}  // namespace tetloom::detail
