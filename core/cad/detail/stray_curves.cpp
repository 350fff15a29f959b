#include "core/cad/detail/stray_curves.hpp"

#include <algorithm>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <cmath>
#include <GCPnts_AbscissaPoint.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Line.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <GeomAdaptor_Curve.hxx>
#include <GeomAPI_ProjectPointOnCurve.hxx>
#include <optional>
#include <ShapeFix_Edge.hxx>
#include <ShapeFix_ShapeTolerance.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Vertex.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>

namespace tetloom::cad {
namespace {

struct Piece {
  Handle(Geom_Curve) curve;
  double first = 0, last = 0;
};

struct Ends {
  gp_Pnt first, last;
};

double gap(const Piece& piece, const Ends& ends) {
  return std::max(piece.curve->Value(piece.first).Distance(ends.first),
                  piece.curve->Value(piece.last).Distance(ends.last));
}

bool is_stray(const Piece& piece, const Ends& ends) {
  constexpr double kFar = 0.05;  // of the edge
  const double missed = gap(piece, ends);
  if (missed <= 100 * Precision::Confusion()) return false;
  const GeomAdaptor_Curve adaptor(piece.curve, piece.first, piece.last);
  return missed > kFar * GCPnts_AbscissaPoint::Length(adaptor);
}

Handle(Geom_Curve) untrimmed(Handle(Geom_Curve) curve) {
  while (curve->IsKind(STANDARD_TYPE(Geom_TrimmedCurve)))
    curve = Handle(Geom_TrimmedCurve)::DownCast(curve)->BasisCurve();
  return curve;
}

std::optional<double> parameter_of(const Handle(Geom_Curve) & curve, const gp_Pnt& point) {
  const GeomAPI_ProjectPointOnCurve projection(point, curve);
  if (projection.NbPoints() > 0) return projection.LowerDistanceParameter();
  const double first = curve->FirstParameter(), last = curve->LastParameter();
  if (std::abs(first) > 1e50 || std::abs(last) > 1e50) return {};
  return curve->Value(first).Distance(point) < curve->Value(last).Distance(point) ? first : last;
}

/// The part of the whole curve between the two ends.
std::optional<Piece> cut_anew(const Handle(Geom_Curve) & whole, const Ends& ends) {
  const auto first = parameter_of(whole, ends.first), last = parameter_of(whole, ends.last);
  if (!first || !last || *first == *last) return {};
  if (*first < *last) return Piece{whole, *first, *last};
  if (whole->IsPeriodic()) return Piece{whole, *first, *last + whole->Period()};
  return Piece{whole->Reversed(), whole->ReversedParameter(*first), whole->ReversedParameter(*last)};
}

std::optional<Piece> repaired(const Piece& piece, const Ends& ends) {
  const Handle(Geom_Curve) whole = untrimmed(piece.curve);
  if (whole->IsKind(STANDARD_TYPE(Geom_Line))) {
    const gp_Vec along(ends.first, ends.last);
    if (along.Magnitude() <= Precision::Confusion()) return {};
    return Piece{new Geom_Line(ends.first, gp_Dir(along)), 0, along.Magnitude()};
  }
  constexpr double kBetter = 0.1;
  const std::optional<Piece> found = cut_anew(whole, ends);
  return found && gap(*found, ends) < kBetter * gap(piece, ends) ? found : std::nullopt;
}

void replace_curve(const TopoDS_Edge& edge, const Piece& piece, const TopTools_ListOfShape& faces) {
  BRep_Builder builder;
  const double tolerance = BRep_Tool::Tolerance(edge);
  for (const TopoDS_Shape& shape : faces) {
    const TopoDS_Face face = TopoDS::Face(shape.Oriented(TopAbs_FORWARD));
    builder.UpdateEdge(edge, Handle(Geom2d_Curve)(), face, tolerance);
  }
  builder.UpdateEdge(edge, piece.curve, tolerance);
  builder.Range(edge, piece.first, piece.last);
  ShapeFix_Edge fix;
  for (const TopoDS_Shape& shape : faces) fix.FixAddPCurve(edge, TopoDS::Face(shape.Oriented(TopAbs_FORWARD)), false);
}

/// As large as the gaps to the edges at the vertex, no larger.
void fit_tolerance(const TopoDS_Vertex& vertex, const TopTools_ListOfShape& edges) {
  double needed = Precision::Confusion();
  for (const TopoDS_Shape& shape : edges) {
    const TopoDS_Edge edge = TopoDS::Edge(shape.Oriented(TopAbs_FORWARD));
    double first, last;
    const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
    if (curve.IsNull()) continue;
    TopoDS_Vertex start, end;
    TopExp::Vertices(edge, start, end);
    const gp_Pnt point = BRep_Tool::Pnt(vertex);
    if (start.IsSame(vertex)) needed = std::max(needed, 1.001 * curve->Value(first).Distance(point));
    if (end.IsSame(vertex)) needed = std::max(needed, 1.001 * curve->Value(last).Distance(point));
    needed = std::max(needed, BRep_Tool::Tolerance(edge));
  }
  if (needed < BRep_Tool::Tolerance(vertex)) ShapeFix_ShapeTolerance().SetTolerance(vertex, needed, TopAbs_VERTEX);
}

}  // namespace

std::size_t repair_stray_curves(const TopoDS_Shape& root) {
  TopTools_IndexedDataMapOfShapeListOfShape edge_to_faces, vertex_to_edges;
  TopExp::MapShapesAndAncestors(root, TopAbs_EDGE, TopAbs_FACE, edge_to_faces);
  std::size_t count = 0;
  for (int i = 1; i <= edge_to_faces.Extent(); ++i) {
    const TopoDS_Edge edge = TopoDS::Edge(edge_to_faces.FindKey(i).Oriented(TopAbs_FORWARD));
    Piece piece;
    piece.curve = BRep_Tool::Curve(edge, piece.first, piece.last);
    TopoDS_Vertex first, last;
    TopExp::Vertices(edge, first, last);
    if (piece.curve.IsNull() || first.IsNull() || last.IsNull() || BRep_Tool::Degenerated(edge)) continue;
    const Ends ends{BRep_Tool::Pnt(first), BRep_Tool::Pnt(last)};
    if (!is_stray(piece, ends)) continue;
    const std::optional<Piece> better = repaired(piece, ends);
    if (!better) continue;
    replace_curve(edge, *better, edge_to_faces(i));
    if (count++ == 0) TopExp::MapShapesAndAncestors(root, TopAbs_VERTEX, TopAbs_EDGE, vertex_to_edges);
    for (const TopoDS_Vertex& vertex : {first, last})
      if (vertex_to_edges.Contains(vertex)) fit_tolerance(vertex, vertex_to_edges.FindFromKey(vertex));
  }
  return count;
}

}  // namespace tetloom::cad
