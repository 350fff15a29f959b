#pragma once
// One face of a shape with its edges, apart from the rest. Private to core/cad.
#include <memory>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <vector>

#include "core/cad/detail/tessellate.hpp"
#include "core/cad/detail/topology.hpp"

namespace tetloom::cad {

/// All that is needed of a shape to answer questions about one of its faces.
class FaceShape {
 public:
  /// `edges`: those that edges_of says, in this order, forward. `face`: forward. `facets`: see there; may be null.
  FaceShape(TopoDS_Face face, const std::vector<ModelEdgeId>& ids, const std::vector<TopoDS_Edge>& edges,
            std::shared_ptr<SharedFacets> facets);

  const TopoDS_Face& face() const { return face_; }
  /// Pre: an edge of the face.
  const TopoDS_Edge& edge(ModelEdgeId id) const;
  SharedFacets* facets() const { return facets_.get(); }

 private:
  struct Edge {
    ModelEdgeId id;
    TopoDS_Edge shape;
  };
  TopoDS_Face face_;
  std::vector<Edge> edges_;  // ascending
  std::shared_ptr<SharedFacets> facets_;
};

/// The edges of a face, each once, in the order of its loops.
std::vector<ModelEdgeId> edges_of(const ModelTopology& topology, ModelFaceId id);

FaceShape face_shape(const ShapeTables& shapes, const ModelTopology& topology, ModelFaceId id);

}  // namespace tetloom::cad
