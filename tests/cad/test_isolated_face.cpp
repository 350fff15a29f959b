// Faces that are repaired apart from their neighbours, and what comes back of them.
#include <BRep_Builder.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_Tool.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <catch2/catch.hpp>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <gp_Circ.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include "core/cad/detail/isolated_face.hpp"
#include "core/cad/detail/validity.hpp"

using namespace tetloom;

namespace {

constexpr cad::FixPrecision kPrecision{1e-5, 1};

void drop_parameter_curves(const TopoDS_Shape& shape) {
  for (TopExp_Explorer edge(shape, TopAbs_EDGE); edge.More(); edge.Next()) {
    BRep_ListOfCurveRepresentation& curves = Handle(BRep_TEdge)::DownCast(edge.Current().TShape())->ChangeCurves();
    for (BRep_ListOfCurveRepresentation::Iterator curve(curves); curve.More();) {
      if (curve.Value()->IsCurveOnSurface()) {
        curves.Remove(curve);
      } else {
        curve.Next();
      }
    }
  }
}

TopoDS_Face curved_face(const TopoDS_Shape& body) {
  for (TopExp_Explorer face(body, TopAbs_FACE); face.More(); face.Next()) {
    const Handle(Geom_Surface) surface = BRep_Tool::Surface(TopoDS::Face(face.Current()));
    if (surface->IsKind(STANDARD_TYPE(Geom_CylindricalSurface)))
      return TopoDS::Face(face.Current().Oriented(TopAbs_FORWARD));
  }
  return {};
}

std::size_t count_missing_curves(const TopoDS_Face& face) {
  std::size_t count = 0;
  double first, last;
  for (TopExp_Explorer edge(face, TopAbs_EDGE); edge.More(); edge.Next())
    count += BRep_Tool::CurveOnSurface(TopoDS::Edge(edge.Current()), face, first, last).IsNull() ? 1 : 0;
  return count;
}

/// The quarter of a ball's skin about its pole, whose rim runs through the pole in the middle of an edge.
TopoDS_Face face_with_pole_on_edge() {
  const Handle(Geom_Surface) sphere = new Geom_SphericalSurface(gp_Ax3(), 5);
  const gp_Circ meridian(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, -1, 0), gp_Dir(1, 0, 0)), 5);
  const gp_Circ equator(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1), gp_Dir(1, 0, 0)), 5);
  const TopoDS_Edge below = BRepBuilderAPI_MakeEdge(equator, gp_Pnt(5, 0, 0), gp_Pnt(-5, 0, 0));

  BRepBuilderAPI_MakeWire wire(below);
  BRep_Builder builder;
  TopoDS_Face face;
  builder.MakeFace(face, sphere, 1e-7);
  const TopoDS_Edge over = BRepBuilderAPI_MakeEdge(meridian, TopExp::FirstVertex(below), TopExp::LastVertex(below));
  wire.Add(TopoDS::Edge(over.Reversed()));
  builder.Add(face, wire.Wire());
  return face;
}

}  // namespace

TEST_CASE("a face gets its parameter curves, and its edges stay those of its neighbours") {
  const TopoDS_Shape body = BRepPrimAPI_MakeCylinder(5, 10, 2).Shape();
  drop_parameter_curves(body);
  const TopoDS_Face face = curved_face(body);
  TopTools_IndexedMapOfShape before, after;
  TopExp::MapShapes(face, TopAbs_EDGE, before);
  REQUIRE(count_missing_curves(face) == 4);

  cad::IsolatedFace isolated(face);
  REQUIRE(isolated.fix(kPrecision));
  CHECK(count_missing_curves(face) == 4);  // nobody else has seen anything yet

  BRepTools_ReShape context;
  isolated.put_back(context);
  const TopoDS_Face fixed = TopoDS::Face(context.Apply(face));
  CHECK(count_missing_curves(fixed) == 0);
  CHECK(cad::is_valid_face(fixed));
  TopExp::MapShapes(fixed, TopAbs_EDGE, after);
  REQUIRE(after.Extent() == before.Extent());
  for (int i = 1; i <= before.Extent(); ++i) CHECK(after.Contains(before(i)));
}

TEST_CASE("tolerances that a face needs reach its edges and vertices") {
  const TopoDS_Shape body = BRepPrimAPI_MakeBox(1, 1, 1).Shape();
  const TopExp_Explorer first(body, TopAbs_FACE);
  const TopoDS_Face face = TopoDS::Face(first.Current().Oriented(TopAbs_FORWARD));
  const TopoDS_Vertex vertex = TopoDS::Vertex(TopExp_Explorer(face, TopAbs_VERTEX).Current());
  const gp_Pnt place = BRep_Tool::Pnt(vertex).Translated(gp_Vec(1e-4, 1e-4, 1e-4));
  BRep_Builder().UpdateVertex(vertex, place, 1e-7);
  REQUIRE_FALSE(cad::is_valid_face(face));

  cad::IsolatedFace isolated(face);
  REQUIRE(isolated.fix(kPrecision));
  BRepTools_ReShape context;
  isolated.put_back(context);
  CHECK(cad::is_valid_face(TopoDS::Face(context.Apply(face))));
  CHECK(BRep_Tool::Tolerance(vertex) > 1e-4);
}

TEST_CASE("a face that needs other edges than it has is left to the repair of its body") {
  const TopoDS_Face face = face_with_pole_on_edge();
  cad::IsolatedFace isolated(face);
  CHECK_FALSE(isolated.fix(kPrecision));
  CHECK(count_missing_curves(face) == 2);
}
