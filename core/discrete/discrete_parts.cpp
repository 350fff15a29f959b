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
  on_edges_.vert_to_model_edge.assign(surface_.points.size(), kNone);
  on_edges_.vert_to_parameter.assign(surface_.points.size(), 0);
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
      on_edges_.vert_to_model_edge[verts[i]] = edge, on_edges_.vert_to_parameter[verts[i]] = length;
    }
    edge_lengths_.push_back(length);
  }
}

const FaceFacets& DiscreteParts::face(std::uint32_t face) const {
  LazyFace& lazy = faces_[face];
  std::call_once(lazy.once, [&] { collect_face(surface_, segmentation_, members_, on_edges_, face, lazy.facets); });
  return lazy.facets;
}

void DiscreteParts::put_face(MessageWriter& writer, std::uint32_t face) const {
  FaceFacets facets;
  collect_face(surface_, segmentation_, members_, on_edges_, face, facets);
  put_facets(writer, facets);
}

}  // namespace tetloom::detail
