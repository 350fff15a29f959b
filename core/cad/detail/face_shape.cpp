#include "core/cad/detail/face_shape.hpp"

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "tetloom/assert.hpp"

namespace tetloom::cad {

FaceShape::FaceShape(TopoDS_Face face, const std::vector<ModelEdgeId>& ids, const std::vector<TopoDS_Edge>& edges,
                     std::shared_ptr<SharedFacets> facets)
    : face_(std::move(face)), facets_(std::move(facets)) {
  TETLOOM_ASSERT(ids.size() == edges.size());
  for (std::size_t i = 0; i < ids.size(); ++i) edges_.push_back({ids[i], edges[i]});
  std::ranges::sort(edges_, {}, [](const Edge& edge) { return edge.id.value; });
}

const TopoDS_Edge& FaceShape::edge(ModelEdgeId id) const {
  const auto found = std::ranges::lower_bound(edges_, id.value, {}, [](const Edge& edge) { return edge.id.value; });
  TETLOOM_ASSERT(found != edges_.end() && found->id.value == id.value);
  return found->shape;
}

std::vector<ModelEdgeId> edges_of(const ModelTopology& topology, ModelFaceId id) {
  std::vector<ModelEdgeId> edges;
  std::unordered_set<std::uint32_t> known;
  for (const ModelLoop& loop : topology.face_to_loops[id.value])
    for (const EdgeUse& use : loop)
      if (known.insert(use.edge.value).second) edges.push_back(use.edge);
  return edges;
}

FaceShape face_shape(const ShapeTables& shapes, const ModelTopology& topology, ModelFaceId id) {
  const std::vector<ModelEdgeId> ids = edges_of(topology, id);
  std::vector<TopoDS_Edge> edges;
  for (const ModelEdgeId edge : ids) edges.push_back(shapes.edge(edge));
  return {shapes.face(id), ids, edges, shapes.facets};
}

}  // namespace tetloom::cad
