#include "tests/cad/faulty_samples.hpp"

#include <array>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_Copy.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepTools.hxx>
#include <cmath>
#include <Geom2d_Line.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_Circle.hxx>
#include <Geom_Line.hxx>
#include <Geom_Plane.hxx>
#include <gp_Ax2.hxx>
#include <gp_Circ.hxx>
#include <gp_Pln.hxx>
#include <stdexcept>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <vector>

#include "tests/cad/shape_lists.hpp"

namespace tetloom::test {
namespace {

std::vector<TopoDS_Shape> loose_faces_of(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Shape> result;
  for (const TopoDS_Shape& face : faces_of(shape)) result.push_back(BRepBuilderAPI_Copy(face).Shape());
  return result;
}

std::vector<TopoDS_Shape> operator+(std::vector<TopoDS_Shape> a, const std::vector<TopoDS_Shape>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TopoDS_Solid solid_of(const std::vector<TopoDS_Shape>& faces) {
  TopoDS_Shell shell;
  TopoDS_Solid solid;
  BRep_Builder builder;
  builder.MakeShell(shell);
  for (const TopoDS_Shape& face : faces) builder.Add(shell, face);
  shell.Closed(true);
  builder.MakeSolid(solid);
  builder.Add(solid, shell);
  return solid;
}

TopoDS_Shape box_at(double x, double y, double z, double edge) {
  return BRepPrimAPI_MakeBox(gp_Pnt(x, y, z), gp_Pnt(x + edge, y + edge, z + edge)).Shape();
}

TopoDS_Vertex vertex_at(double x, double y, double tolerance = 1e-7) {
  TopoDS_Vertex vertex;
  BRep_Builder().MakeVertex(vertex, gp_Pnt(x, y, 0), tolerance);
  return vertex;
}

TopoDS_Edge line(const TopoDS_Vertex& a, const TopoDS_Vertex& b) { return BRepBuilderAPI_MakeEdge(a, b); }

TopoDS_Wire wire_of(const std::vector<TopoDS_Shape>& edges) {
  TopoDS_Wire wire;
  BRep_Builder builder;
  builder.MakeWire(wire);
  for (const TopoDS_Shape& edge : edges) builder.Add(wire, edge);
  wire.Closed(true);
  return wire;
}

TopoDS_Face face_of(const Handle(Geom_Surface) & surface, const std::vector<TopoDS_Wire>& wires) {
  TopoDS_Face face;
  BRep_Builder builder;
  builder.MakeFace(face, surface, 1e-7);
  for (const TopoDS_Wire& wire : wires) builder.Add(face, wire);
  return face;
}

Handle(Geom_Surface) ground() { return new Geom_Plane(gp::XOY()); }

TopoDS_Shape touching_loops() {
  constexpr double tolerance = 1e-4, beyond = 5e-5;
  const Handle(Geom_Surface) plane = ground();
  const TopoDS_Vertex touching = vertex_at(5, 10, tolerance);
  const TopoDS_Vertex corners[] = {vertex_at(0, 0), vertex_at(10, 0), vertex_at(10, 10), touching, vertex_at(0, 10)};
  std::vector<TopoDS_Shape> outer;
  for (int i = 0; i < 5; ++i) outer.push_back(line(corners[i], corners[(i + 1) % 5]));
  const TopoDS_Vertex left = vertex_at(4, 6), right = vertex_at(6, 6);
  const auto stray = [&](const TopoDS_Vertex& to, double x, double y) {
    TopoDS_Edge edge = line(touching, to);
    double first, last;
    BRep_Tool::Range(edge, first, last);
    const gp_Pnt2d start(5, 10 + beyond);
    const gp_Vec2d along((x - start.X()) / last, (y - start.Y()) / last);
    // A line's parameter is its length, which is exact enough for a curve that is off by the tolerance anyway.
    BRep_Builder().UpdateEdge(edge, new Geom2d_Line(start, gp_Dir2d(along)), plane, TopLoc_Location(), tolerance);
    return edge;
  };
  // The hole is run through clockwise.
  const TopoDS_Edge from_right = stray(right, 6, 6), to_left = stray(left, 4, 6);
  return face_of(plane, {wire_of(outer), wire_of({from_right, line(right, left), to_left.Reversed()})});
}

TopoDS_Face tangent_hole() {
  constexpr double radius = 3, cut = 1e-4, tolerance = 2e-4;
  const double half = std::sqrt(radius * radius - (radius - cut) * (radius - cut));
  const TopoDS_Vertex a = vertex_at(10 - half, 0, tolerance), b = vertex_at(10 + half, 0, tolerance);
  const TopoDS_Vertex corners[] = {vertex_at(0, 0), a, b, vertex_at(20, 0), vertex_at(20, 20), vertex_at(0, 20)};
  std::vector<TopoDS_Shape> outer;
  for (int i = 0; i < 6; ++i) outer.push_back(line(corners[i], corners[(i + 1) % 6]));
  const gp_Circ circle(gp_Ax2(gp_Pnt(10, radius - cut, 0), gp_Dir(0, 0, 1)), radius);
  TopoDS_Edge large = BRepBuilderAPI_MakeEdge(circle, b, a), small = BRepBuilderAPI_MakeEdge(circle, a, b);
  BRep_Builder().UpdateEdge(small, tolerance);
  BRep_Builder().UpdateEdge(TopoDS::Edge(outer[1]), tolerance);
  return face_of(ground(), {wire_of(outer), wire_of({large.Reversed(), small.Reversed()})});
}

TopoDS_Shape doubled_edge() {
  const TopoDS_Vertex low = vertex_at(0, 0), high = vertex_at(0, 10);
  const auto square = [&](double x) {
    const TopoDS_Vertex far_low = vertex_at(x, 0), far_high = vertex_at(x, 10);
    return std::vector<TopoDS_Shape>{line(low, far_low), line(far_low, far_high), line(far_high, high),
                                     line(high, low)};
  };
  return compound({face_of(ground(), {wire_of(square(10))}), face_of(ground(), {wire_of(square(-10))}).Reversed()});
}

TopoDS_Shape folded_corner() {
  TColgp_Array2OfPnt poles(1, 2, 1, 2);
  poles(1, 1) = gp_Pnt(4, 4, 0);
  poles(1, 2) = gp_Pnt(4, 10, 1);
  poles(2, 1) = gp_Pnt(10, 4, 0);
  poles(2, 2) = gp_Pnt(0, 0, 0);
  const Handle(Geom_Surface) surface = new Geom_BezierSurface(poles);
  return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(surface, 1e-7).Face(), gp_Vec(0, 0, 5)).Shape();
}

TopoDS_Shape curve_short_of_vertex() {
  const TopoDS_Shape box = BRepBuilderAPI_Copy(box_at(0, 0, 0, 10)).Shape();
  const TopoDS_Edge edge = TopoDS::Edge(TopExp_Explorer(box, TopAbs_EDGE).Current());
  const gp_Pnt from = BRep_Tool::Pnt(TopExp::FirstVertex(edge)), to = BRep_Tool::Pnt(TopExp::LastVertex(edge));
  BRep_Builder builder;
  builder.UpdateEdge(edge, new Geom_Line(from, gp_Dir(gp_Vec(to, from))), 1e-7);
  builder.Range(edge, 0, 10);
  builder.UpdateVertex(TopExp::LastVertex(edge), 20);
  std::vector<TopoDS_Shape> faces;
  for (const TopoDS_Shape& face : faces_of(box)) {  // on planes the parameter curves follow from the curve in space
    builder.UpdateEdge(edge, Handle(Geom2d_Curve)(), TopoDS::Face(face), 1e-7);
    faces.push_back(face);
  }
  return box;
}

TopoDS_Face collapsed(const gp_Pnt& a, const gp_Pnt& b, const gp_Dir& normal) {
  const TopoDS_Vertex first = BRepBuilderAPI_MakeVertex(a), second = BRepBuilderAPI_MakeVertex(b);
  return face_of(new Geom_Plane(a, normal), {wire_of({line(first, second), line(second, first)})});
}

TopoDS_Shape collapsed_faces() {
  TColgp_Array2OfPnt poles(1, 2, 1, 2);
  poles.Init(gp_Pnt(0, 0, 0));
  const Handle(Geom_Surface) point = new Geom_BezierSurface(poles);
  return compound(loose_faces_of(box_at(0, 0, 0, 10)) +
                  std::vector<TopoDS_Shape>{collapsed({0, 0, 0}, {10, 0, 0}, {0, 0, 1}),
                                            collapsed({0, 0, 10}, {0, 10, 10}, {0, 0, 1}),
                                            BRepBuilderAPI_MakeFace(point, 1e-7).Shape()});
}

// The box's opposite face is whole, however deep the hole is.
TopoDS_Shape box_with_hole(double depth) {
  const TopoDS_Shape box = box_at(0, 0, 0, 10);
  const TopoDS_Shape hole = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(5, 5, 0), gp_Dir(0, 0, 1)), 2, depth).Shape();
  std::vector<TopoDS_Shape> faces;
  TopoDS_Wire mouth;
  for (const TopoDS_Shape& face : faces_of(hole)) {
    const TopoDS_Wire outline = BRepTools::OuterWire(TopoDS::Face(face));
    const bool plane = BRep_Tool::Surface(TopoDS::Face(face))->IsKind(STANDARD_TYPE(Geom_Plane));
    const bool bottom = plane && BRep_Tool::Pnt(TopoDS::Vertex(TopExp_Explorer(face, TopAbs_VERTEX).Current())).Z() < 5;
    if (bottom)
      mouth = outline;
    else
      faces.push_back(face.Reversed());
  }
  for (const TopoDS_Shape& shape : faces_of(box)) {
    const TopoDS_Face face = TopoDS::Face(shape);
    bool bottom = true;
    for (TopExp_Explorer v(face, TopAbs_VERTEX); v.More(); v.Next())
      bottom = bottom && BRep_Tool::Pnt(TopoDS::Vertex(v.Current())).Z() < 5;
    if (!bottom) {
      faces.push_back(face);
      continue;
    }
    BRepBuilderAPI_MakePolygon outline({0, 0, 0}, {0, 10, 0}, {10, 10, 0}, {10, 0, 0}, true);
    faces.push_back(face);
    BRepBuilderAPI_MakeFace holed(face, TopoDS::Wire(mouth.Reversed()));
    faces.back() = holed.Face();
  }
  return solid_of(faces);
}

TopoDS_Shape flat_solid() {
  const Handle(Geom_Surface) plane = ground();
  const TopoDS_Vertex corners[] = {vertex_at(20, 0), vertex_at(30, 0), vertex_at(30, 10), vertex_at(20, 10)};
  std::vector<TopoDS_Shape> edges;
  for (int i = 0; i < 4; ++i) edges.push_back(line(corners[i], corners[(i + 1) % 4]));
  const TopoDS_Face up = face_of(plane, {wire_of(edges)}), down = face_of(plane, {wire_of(edges)});
  return solid_of({up, down.Reversed()});
}

// Apart from each other, and each a shape of its own.
TopoDS_Shape row_of_boxes_with_holes() {
  std::vector<TopoDS_Shape> solids{box_at(0, 20, 0, 10)};
  for (int i = 0; i < 6; ++i) {
    gp_Trsf shift;
    shift.SetTranslation(gp_Vec(20.0 * i, 0, 0));
    solids.push_back(BRepBuilderAPI_Transform(box_with_hole(12), shift, true).Shape());
  }
  return compound(solids);
}

TopoDS_Shape make_faulty(Fault fault) {
  switch (fault) {
    case Fault::TouchingLoops: return touching_loops();
    case Fault::TangentHole: return tangent_hole();
    case Fault::TangentHoleInPlate: return BRepPrimAPI_MakePrism(tangent_hole(), gp_Vec(0, 0, 5)).Shape();
    case Fault::DoubledEdge: return doubled_edge();
    case Fault::FoldedCorner: return folded_corner();
    case Fault::CurveShortOfVertex: return curve_short_of_vertex();
    case Fault::CrossingShells:
      return compound(
          loose_faces_of(box_at(0, 0, 0, 10)) +
          loose_faces_of(BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-3, 5, 3), gp_Dir(0, 0, 1)), 8, 4).Shape()));
    case Fault::NestedShells: return compound(loose_faces_of(box_at(0, 0, 0, 10)) + loose_faces_of(box_at(3, 3, 3, 4)));
    case Fault::CollapsedFaces: return collapsed_faces();
    case Fault::FloorBeyondOuterFace: return compound({box_with_hole(12), box_at(20, 0, 0, 10)});
    case Fault::FloorsBeyondOuterFaces: return row_of_boxes_with_holes();
    case Fault::FloorInOuterFace: return box_with_hole(10);
    case Fault::FloorWithoutThickness: return box_with_hole(10 - 1e-11);
    case Fault::FlatSolid: return flat_solid();
    case Fault::FlatSolidAndBox: return compound({flat_solid(), box_at(0, 0, 0, 10)});
    case Fault::OverlappingBoxes: return compound({box_at(0, 0, 0, 10), box_at(5, 5, 5, 10)});
    case Fault::NarrowStep:
      return BRepAlgoAPI_Cut(BRepPrimAPI_MakeCylinder(10, 20).Shape(),
                             BRepPrimAPI_MakeBox(gp_Pnt(-49, -20, 10), 40, 40, 40).Shape())
          .Shape();
    case Fault::ThinRod: return BRepPrimAPI_MakeCylinder(0.1, 10).Shape();
  }
  throw std::runtime_error("unknown fault");
}

}  // namespace

void write_faulty(Fault fault, const std::filesystem::path& path) {
  if (!BRepTools::Write(make_faulty(fault), path.c_str())) throw std::runtime_error("could not write " + path.string());
}

}  // namespace tetloom::test
