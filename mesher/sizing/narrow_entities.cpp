#include "mesher/sizing/narrow_entities.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "mesher/sizing/build_size_field.hpp"
#include "mesher/sizing/model_facets.hpp"

namespace tetloom {

double area_of(const Tessellation& facets) {
  double area = 0;
  for (const auto& [a, b, c] : facets.tri_to_vert)
    area += 0.5 * norm(cross(facets.points[b] - facets.points[a], facets.points[c] - facets.points[a]));
  return area;
}

double mean_width(const GeometricModel& model, ModelFaceId face, const Tessellation& facets) {
  std::vector<ModelEdgeId> edges;
  for (const ModelLoop& loop : model.topology().face_to_loops[face.value])
    for (const EdgeUse& use : loop) edges.push_back(use.edge);
  double rim = 0;
  for (const ModelEdgeId edge : edges) {
    const bool is_seam = std::ranges::count(edges, edge) > 1;
    if (is_seam || model.topology().edges[edge.value].degenerate) continue;
    rim += length_up_to(*model.edge_geometry(edge), HUGE_VAL);
  }
  return rim > 0 ? 2 * area_of(facets) / rim : HUGE_VAL;
}

std::vector<double> small_face_limits(const GeometricModel& model) {
  const ModelTopology& topology = model.topology();
  std::vector<double> limits(topology.face_count(), HUGE_VAL);
  for (std::size_t r = 0; r < topology.region_count(); ++r) {
    double area = 0;
    tolerate_bad_geometry([&] {
      for (const ModelFaceId face : topology.region_to_faces[r]) area += model.area(face);
    });
    const double volume = std::abs(model.volume(ModelRegionId(r)));
    if (!(area > 0 && volume > 0)) continue;
    for (const ModelFaceId face : topology.region_to_faces[r])
      limits[face.value] = std::min(limits[face.value], kSmallOfSolid * 2 * volume / area);
  }
  return limits;
}

double length_up_to(EdgeGeometry& edge, double most) {
  constexpr int kPieces = 16;
  const ParameterRange range = edge.range();
  Vec3 before = edge.evaluate(range.lo);
  double length = 0;
  for (int i = 1; i <= kPieces && length < most; ++i) {
    const Vec3 point = edge.evaluate(range.lo + (range.hi - range.lo) * i / kPieces);
    length += distance(before, point);
    before = point;
  }
  return length;
}

}  // namespace tetloom
