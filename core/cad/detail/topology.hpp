#pragma once
// From an OpenCASCADE shape to the tables of a ModelTopology, and back from ids to shapes. Private to core/cad.
#include <memory>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom::cad {

class SharedFacets;

/// The shapes behind the entities: entity i is shape i + 1 of its map. Numbering follows TopExp::MapShapes, so it
/// depends on the file alone. The same shape in two places is two entities.
struct ShapeTables {
  TopTools_IndexedMapOfShape vertices, edges, faces, solids;
  std::shared_ptr<SharedFacets> facets;  ///< may be null

  TopoDS_Vertex vertex(ModelVertexId id) const;
  /// Forward, so that it runs along its curve.
  TopoDS_Edge edge(ModelEdgeId id) const;
  /// Forward, so that its normal is du × dv.
  TopoDS_Face face(ModelFaceId id) const;
  /// As it is stored, so that its faces point out of it.
  TopoDS_Solid solid(ModelRegionId id) const;
};

/// What the shape says, and what about it deserves a warning.
struct ShapeTopology {
  ShapeTables shapes;
  ModelTopology topology;
  std::vector<Diagnostic> warnings;
};

/// Reads solids and faces at any nesting. Edges and vertices that bound no face are left out with a warning.
/// Errors: InputUnsuitable (edges without ends).
ShapeTopology make_topology(const TopoDS_Shape& root);

}  // namespace tetloom::cad
