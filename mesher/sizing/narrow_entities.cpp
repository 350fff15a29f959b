#include "mesher/sizing/narrow_entities.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetloom {

double mean_width(const GeometricModel& model, ModelFaceId face, const Tessellation& facets) {
  double area = 0;
  for (const auto& [a, b, c] : facets.tri_to_vert)
    area += 0.5 * norm(cross(facets.points[b] - facets.points[a], facets.points[c] - facets.points[a]));
  std::vector<ModelEdgeId> edges;
  for (const ModelLoop& loop : model.topology().face_to_loops[face.value])
    for (const EdgeUse& use : loop) edges.push_back(use.edge);
  double rim = 0;
  for (const ModelEdgeId edge : edges) {
    const bool is_seam = std::ranges::count(edges, edge) > 1;
    if (is_seam || model.topology().edges[edge.value].degenerate) continue;
    rim += length_up_to(*model.edge_geometry(edge), HUGE_VAL);
  }
  return rim > 0 ? 2 * area / rim : HUGE_VAL;
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
