#include "core/cad/detail/tessellate.hpp"

#include <algorithm>
#include <BRep_Tool.hxx>
#include <BRepBuilderAPI_Copy.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <map>
#include <memory>
#include <mutex>
#include <Poly_PolygonOnTriangulation.hxx>
#include <Poly_Triangulation.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>

#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/face_shape.hpp"

namespace tetloom::cad {
namespace {

/// Nodes on edges get the edge and its parameter, nodes at the ends of edges the vertex.
class BoundaryMarker {
 public:
  BoundaryMarker(const ModelTopology& topology, const Handle(Poly_Triangulation) & facets, const TopLoc_Location& place,
                 Tessellation& out)
      : topology_(topology), facets_(facets), place_(place), out_(out) {}

  void mark(const EdgeUse& use, const TopoDS_Edge& oriented) {
    const Handle(Poly_PolygonOnTriangulation) polygon = BRep_Tool::PolygonOnTriangulation(oriented, facets_, place_);
    if (polygon.IsNull()) return;
    const ModelEdgeTopology& edge = topology_.edges[use.edge.value];
    const int count = polygon->NbNodes();
    for (int i = 1; i <= count; ++i) {
      const std::size_t node = static_cast<std::size_t>(polygon->Node(i)) - 1;
      if (i == 1 || i == count || edge.degenerate) {
        out_.classification[node] = edge.vertices[i == count ? 1 : 0];
      } else if (out_.classification[node].dim != 0) {
        out_.classification[node] = use.edge;
        out_.edge_parameter[node] = polygon->Parameter(i);
      }
    }
  }

 private:
  const ModelTopology& topology_;
  const Handle(Poly_Triangulation) & facets_;
  const TopLoc_Location& place_;
  Tessellation& out_;
};

void copy_facets(const Handle(Poly_Triangulation) & facets, const TopLoc_Location& place, ModelFaceId id,
                 Tessellation& out) {
  const gp_Trsf transform = place.Transformation();
  for (int i = 1; i <= facets->NbNodes(); ++i) {
    out.points.push_back(to_vec3(facets->Node(i).Transformed(transform)));
    out.uv.push_back(to_vec2(facets->UVNode(i)));
  }
  out.classification.assign(out.points.size(), id);
  out.edge_parameter.assign(out.points.size(), 0.0);
  for (int i = 1; i <= facets->NbTriangles(); ++i) {
    int a, b, c;
    facets->Triangle(i).Get(a, b, c);
    out.tri_to_vert.push_back(
        {static_cast<std::uint32_t>(a - 1), static_cast<std::uint32_t>(b - 1), static_cast<std::uint32_t>(c - 1)});
  }
}

struct Facets {
  TopoDS_Face face;  ///< a copy, forward
  TopLoc_Location place;
  Handle(Poly_Triangulation) triangulation;
};

Facets try_facets(const TopoDS_Face& copy, double chord, double angle) {
  Facets result{copy, {}, {}};
  BRepTools::Clean(copy);
  BRepMesh_IncrementalMesh(copy, chord, false, angle, false);
  result.triangulation = BRep_Tool::Triangulation(copy, result.place);
  return result;
}

// BRepMesh finds some sound boundaries self-intersecting at one fineness and not at another.
Facets make_facets(const TopoDS_Face& copy, double chord, double angle) {
  struct Attempt {
    double chord, angle;
  };
  // On cones all around it takes a hundred times as long to fail at small angles, which therefore come last.
  const Attempt attempts[] = {{chord, angle},     {chord / 2, angle}, {chord / 1.5, 1.6 * angle}, {chord, 2 * angle},
                              {chord, 4 * angle}, {chord, angle / 2}, {chord / 4, angle / 2}};
  for (const Attempt& attempt : attempts) {
    const Facets facets = try_facets(copy, attempt.chord, std::min(attempt.angle, 1.5));
    const Handle(Poly_Triangulation)& found = facets.triangulation;
    if (!found.IsNull() && found->NbTriangles() > 0 && found->HasUVNodes()) return facets;
  }
  throw Error(ErrorCode::FaceFailed, "OpenCASCADE could not tessellate the face");
}

}  // namespace

struct SharedFacets::Facetted {
  Facetted(const TopoDS_Face& face, double chord, double angle)
      : copy(face, true, false),
        facets(make_facets(TopoDS::Face(copy.Shape().Oriented(TopAbs_FORWARD)), chord, angle)) {}

  BRepBuilderAPI_Copy copy;
  Facets facets;
};

struct SharedFacets::Entry {
  std::once_flag is_made;
  std::unique_ptr<const Facetted> facetted;
};

SharedFacets::SharedFacets() = default;
SharedFacets::~SharedFacets() = default;

void SharedFacets::add_places(const TopTools_IndexedMapOfShape& faces) {
  const std::lock_guard lock(mutex_);
  std::map<const TopoDS_TShape*, int> places;
  for (int i = 1; i <= faces.Extent(); ++i)
    if (++places[faces(i).TShape().get()] == 2) repeated_.insert(faces(i).TShape());
}

void SharedFacets::add_repeated(const TopoDS_Face& face) {
  const std::lock_guard lock(mutex_);
  repeated_.insert(face.TShape());
}

std::shared_ptr<const SharedFacets::Facetted> SharedFacets::find(const TopoDS_Face& face, double chord, double angle) {
  std::shared_ptr<Entry> entry;
  {
    const std::lock_guard lock(mutex_);
    if (!repeated_.contains(face.TShape())) return nullptr;
    std::shared_ptr<Entry>& known = entries_[{face.TShape().get(), chord, angle}];
    if (!known) known = std::make_shared<Entry>();
    entry = known;
  }
  std::call_once(entry->is_made, [&] {
    entry->facetted = std::make_unique<const Facetted>(TopoDS::Face(face.Located({})), chord, angle);
  });
  return {entry, entry->facetted.get()};
}

Tessellation tessellate_face(const FaceShape& shape, const ModelTopology& topology, ModelFaceId id, double chord,
                             double angle) {
  if (!(chord > 0) || !(angle > 0)) throw Error(ErrorCode::InvalidArgument, "chord and angle must be positive");
  const TopoDS_Face& face = shape.face();
  std::shared_ptr<const SharedFacets::Facetted> made =
      shape.facets() ? shape.facets()->find(face, chord, angle) : nullptr;
  const TopLoc_Location place = made ? face.Location() : TopLoc_Location();  // of the face that was facetted
  if (!made) made = std::make_shared<const SharedFacets::Facetted>(face, chord, angle);
  const Facets& facets = made->facets;
  Tessellation out;
  copy_facets(facets.triangulation, place * facets.place, id, out);
  BoundaryMarker marker(topology, facets.triangulation, facets.place, out);
  const TopLoc_Location back = place.Inverted();
  for (const ModelLoop& loop : topology.face_to_loops[id.value]) {
    for (const EdgeUse& use : loop) {
      const TopoDS_Edge& placed = shape.edge(use.edge);
      const TopoDS_Shape edge = made->copy.ModifiedShape(placed.Located(back * placed.Location()));
      marker.mark(use, TopoDS::Edge(edge.Oriented(use.second_side ? TopAbs_REVERSED : TopAbs_FORWARD)));
    }
  }
  return out;
}

}  // namespace tetloom::cad
