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
#include "core/discrete/segmentation.hpp"

namespace tetloom::detail {

/// A model edge: a polyline over its arc length. Closed when its first and last points are the same.
struct Polyline {
  std::vector<Vec3> points;
  std::vector<double> lengths;  ///< from the start, one per point
  bool closed = false;
};

/// The facet surface and its segmentation, with what edges and faces need of both.
class DiscreteParts {
 public:
  DiscreteParts(FacetSurface&& surface, double feature_angle);

  const FacetSurface& surface() const { return surface_; }
  const Segmentation& segmentation() const { return segmentation_; }
  const FaceMembers& members() const { return members_; }
  const Polyline& polyline(std::uint32_t model_edge) const { return polylines_[model_edge]; }
  const FaceFacets& face(std::uint32_t face) const;
  /// The model edge that has the point inside of it, or kNone; and the arc length there.
  std::uint32_t model_edge_at(std::uint32_t vert) const { return vert_to_model_edge_[vert]; }
  double parameter_at(std::uint32_t vert) const { return vert_to_parameter_[vert]; }

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
  std::vector<std::uint32_t> vert_to_model_edge_;
  std::vector<double> vert_to_parameter_;
  std::unique_ptr<LazyFace[]> faces_;
};

}  // namespace tetloom::detail
