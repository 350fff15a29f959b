#pragma once
// What a discrete model and its edge and face objects share. Private to core/discrete.
//
// Thread safety: immutable, but for the facets of each face, which are collected when they are first asked for, once,
// whichever thread asks; they depend on the surface alone.
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/discrete/face_facets.hpp"
#include "core/discrete/facet_surface.hpp"
#include "core/discrete/polyline.hpp"
#include "core/discrete/segmentation.hpp"

namespace tetloom::detail {

/// The facet surface and its segmentation, with what edges and faces need of both.
class DiscreteParts {
 public:
  DiscreteParts(FacetSurface&& surface, double feature_angle);

  const FacetSurface& surface() const { return surface_; }
  const Segmentation& segmentation() const { return segmentation_; }
  const FaceMembers& members() const { return members_; }
  const Polyline& polyline(std::uint32_t model_edge) const { return polylines_[model_edge]; }
  const std::vector<double>& edge_lengths() const { return edge_lengths_; }
  const FaceFacets& face(std::uint32_t face) const;
  /// Collects a face to pack it, and does not keep it.
  void put_face(MessageWriter& writer, std::uint32_t face) const;

 private:
  struct LazyFace {
    std::once_flag once;
    FaceFacets facets;
  };
  void measure_edges();

  FacetSurface surface_;
  Segmentation segmentation_;
  FaceMembers members_;
  std::vector<Polyline> polylines_;
  std::vector<double> edge_lengths_;
  PlacesOnEdges on_edges_;
  std::unique_ptr<LazyFace[]> faces_;
};

}  // namespace tetloom::detail
