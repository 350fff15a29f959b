#include "core/discrete/discrete_parts.hpp"

#include <utility>

namespace tetloom::detail {

DiscreteParts::DiscreteParts(FacetSurface&& surface, double feature_angle)
    : surface_(std::move(surface)),
      segmentation_(segment_surface(surface_, feature_angle)),
      members_(list_members(segmentation_)),
      faces_(std::make_unique<LazyFace[]>(segmentation_.face_count)) {
  measure_edges();
}

void DiscreteParts::measure_edges() {
  vert_to_model_edge_.assign(surface_.points.size(), kNone);
  vert_to_parameter_.assign(surface_.points.size(), 0);
  polylines_.resize(segmentation_.model_edge_to_verts.size());
  for (std::uint32_t edge = 0; edge < polylines_.size(); ++edge) {
    const auto& verts = segmentation_.model_edge_to_verts[edge];
    Polyline& line = polylines_[edge];
    line.closed = verts.front() == verts.back();
    double length = 0;
    for (std::size_t i = 0; i < verts.size(); ++i) {
      line.points.push_back(surface_.points[verts[i]]);
      if (i > 0) length += distance(line.points[i], line.points[i - 1]);
      line.lengths.push_back(length);
      if (i == 0 || i + 1 == verts.size()) continue;
      vert_to_model_edge_[verts[i]] = edge, vert_to_parameter_[verts[i]] = length;
    }
  }
}

const FaceFacets& DiscreteParts::face(std::uint32_t face) const {
  LazyFace& lazy = faces_[face];
  std::call_once(lazy.once, [&] { collect_face(surface_, segmentation_, members_, face, lazy.facets); });
  return lazy.facets;
}

}  // namespace tetloom::detail
