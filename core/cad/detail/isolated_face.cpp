#include "core/cad/detail/isolated_face.hpp"

#include <BRep_Builder.hxx>
#include <BRep_CurveRepresentation.hxx>
#include <BRep_GCurve.hxx>
#include <BRep_TEdge.hxx>
#include <BRep_Tool.hxx>
#include <cmath>
#include <Precision.hxx>
#include <ShapeBuild_ReShape.hxx>
#include <ShapeFix.hxx>
#include <ShapeFix_Face.hxx>
#include <ShapeFix_Wire.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include "core/cad/detail/validity.hpp"

namespace tetloom::cad {
namespace {

BRep_ListOfCurveRepresentation& curves_of(const TopoDS_Edge& edge) {
  return Handle(BRep_TEdge)::DownCast(edge.TShape())->ChangeCurves();
}

struct Range {
  double first = 0, last = 0;
};

bool is_close(const Range& a, const Range& b) {
  return std::abs(a.first - b.first) <= Precision::PConfusion() && std::abs(a.last - b.last) <= Precision::PConfusion();
}

/// The parameter curves of `from` on a surface become those of `to`, with its range but for rounding.
void move_parameter_curves(const TopoDS_Edge& from, const TopoDS_Edge& to, const Handle(Geom_Surface) & surface) {
  BRep_ListOfCurveRepresentation& target = curves_of(to);
  for (BRep_ListOfCurveRepresentation::Iterator old(target); old.More();) {
    if (old.Value()->IsCurveOnSurface(surface, TopLoc_Location())) {
      target.Remove(old);
    } else {
      old.Next();
    }
  }
  Range range;
  BRep_Tool::Range(to, range.first, range.last);
  for (const Handle(BRep_CurveRepresentation) & curve : curves_of(from)) {
    if (!curve->IsCurveOnSurface(surface, TopLoc_Location())) continue;
    const Handle(BRep_GCurve) on_face = Handle(BRep_GCurve)::DownCast(curve);
    if (is_close({on_face->First(), on_face->Last()}, range)) on_face->SetRange(range.first, range.last);
    target.Append(curve);
  }
}

/// Does `after` consist of what `results` gives for the wires and edges of `before`, in the same order?
template <class Results>
bool has_same_parts(const TopoDS_Shape& before, const TopoDS_Shape& after, const Results& results) {
  TopoDS_Iterator old_part(before, false), new_part(after, false);
  for (; old_part.More() && new_part.More(); old_part.Next(), new_part.Next()) {
    const TopoDS_Shape &a = old_part.Value(), &b = new_part.Value();
    if (a.ShapeType() != b.ShapeType() || a.Orientation() != b.Orientation()) return false;
    const TopoDS_Shape* result = results.Seek(a);
    if (result ? !b.IsSame(*result) : !has_same_parts(a, b, results)) return false;
  }
  return !old_part.More() && !new_part.More();
}

/// Ranges may differ by rounding: ShapeFix computes those of the edges anew that it gives other vertices.
bool has_same_curve(const TopoDS_Edge& a, const TopoDS_Edge& b) {
  Range of_a, of_b;
  const Handle(Geom_Curve) curve_a = BRep_Tool::Curve(a, of_a.first, of_a.last);
  const Handle(Geom_Curve) curve_b = BRep_Tool::Curve(b, of_b.first, of_b.last);
  return curve_a == curve_b && is_close(of_a, of_b) && BRep_Tool::Degenerated(a) == BRep_Tool::Degenerated(b);
}

TopoDS_Face fixed_by_shape_fix(const TopoDS_Face& face, const FixPrecision& precision,
                               const Handle(ShapeBuild_ReShape) & context) {
  const Handle(ShapeFix_Face) fix = new ShapeFix_Face(face);
  fix->SetContext(context);
  fix->SetPrecision(precision.precision);
  fix->SetMaxTolerance(precision.largest);
  fix->FixIntersectingWiresMode() = 0;  // whether wires cross is checked once, when all is done
  fix->FixWireTool()->FixSelfIntersectionMode() = 0;
  fix->FixWireTool()->FixSameParameterMode() = 0;  // below, together with what planes need
  fix->Perform();
  const TopoDS_Shape result = context->Apply(fix->Result());
  if (result.IsNull() || result.ShapeType() != TopAbs_FACE) return {};
  ShapeFix::SameParameter(result, false);
  return TopoDS::Face(result);
}

}  // namespace

IsolatedFace::IsolatedFace(const TopoDS_Face& face) : original_(face) {
  copy_ = TopoDS::Face(copy_children(face));
  for (int i = 1; i <= edges_.Extent(); ++i) drop_other_curves(TopoDS::Edge(edges_(i)));
}

TopoDS_Shape IsolatedFace::copy_children(const TopoDS_Shape& shape) {
  TopoDS_Shape result = shape.EmptyCopied().Oriented(TopAbs_FORWARD);
  BRep_Builder builder;
  for (TopoDS_Iterator child(shape, false, false); child.More(); child.Next()) {
    const TopoDS_Shape& part = child.Value();
    if (!part.Location().IsIdentity()) portable_ = false;
    TopoDS_Shape copy;
    switch (part.ShapeType()) {
      case TopAbs_EDGE: copy = copy_once(part, edges_); break;
      case TopAbs_VERTEX: copy = copy_once(part, vertices_); break;
      default: copy = copy_children(part); break;
    }
    builder.Add(result, copy.Oriented(part.Orientation()));
  }
  result.Closed(shape.Closed());
  return result;
}

TopoDS_Shape IsolatedFace::copy_once(const TopoDS_Shape& shape, Copies& known) {
  const TopoDS_Shape key = shape.Oriented(TopAbs_FORWARD);
  if (const TopoDS_Shape* copy = known.Seek(key)) return *copy;
  const TopoDS_Shape copy = copy_children(key);
  known.Add(key, copy);
  return copy;
}

// They belong to the neighbours, who see to them.
void IsolatedFace::drop_other_curves(const TopoDS_Edge& edge) const {
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(original_);
  BRep_ListOfCurveRepresentation& curves = curves_of(edge);
  for (BRep_ListOfCurveRepresentation::Iterator curve(curves); curve.More();) {
    if (curve.Value()->IsCurveOnSurface() && !curve.Value()->IsCurveOnSurface(surface, TopLoc_Location())) {
      curves.Remove(curve);
    } else {
      curve.Next();
    }
  }
}

bool IsolatedFace::fix(const FixPrecision& precision) {
  if (!portable_) return false;
  try {
    const Handle(ShapeBuild_ReShape) context = new ShapeBuild_ReShape;
    fixed_ = fixed_by_shape_fix(copy_, precision, context);
    for (Copies* copies : {&edges_, &vertices_})
      for (int i = 1; i <= copies->Extent(); ++i) (*copies)(i) = context->Apply((*copies)(i)).Oriented(TopAbs_FORWARD);
    return !fixed_.IsNull() && fits_back() && is_valid_face(fixed_);
  } catch (const Standard_Failure&) {  // as ShapeFix leaves what it cannot repair
    return false;
  }
}

bool IsolatedFace::fits_back() const {
  TopTools_IndexedMapOfShape parts;
  TopExp::MapShapes(fixed_, parts);
  const auto is_part = [&](const TopoDS_Shape& shape, TopAbs_ShapeEnum type) {
    return !shape.IsNull() && shape.ShapeType() == type && parts.Contains(shape);
  };
  for (int i = 1; i <= edges_.Extent(); ++i)
    if (!is_part(edges_(i), TopAbs_EDGE) || !has_same_curve(TopoDS::Edge(edges_.FindKey(i)), TopoDS::Edge(edges_(i))))
      return false;
  for (int i = 1; i <= vertices_.Extent(); ++i) {
    if (!is_part(vertices_(i), TopAbs_VERTEX)) return false;
    const TopoDS_Vertex before = TopoDS::Vertex(vertices_.FindKey(i)), after = TopoDS::Vertex(vertices_(i));
    if (!BRep_Tool::Pnt(before).IsEqual(BRep_Tool::Pnt(after), 0)) return false;
  }
  return true;
}

void IsolatedFace::put_back(BRepTools_ReShape& context) const {
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(fixed_);
  BRep_Builder builder;
  BRepTools_ReShape back;
  for (int i = 1; i <= vertices_.Extent(); ++i) {
    back.Replace(vertices_(i), vertices_.FindKey(i));
    builder.UpdateVertex(TopoDS::Vertex(vertices_.FindKey(i)), BRep_Tool::Tolerance(TopoDS::Vertex(vertices_(i))));
  }
  for (int i = 1; i <= edges_.Extent(); ++i) {
    const TopoDS_Edge edge = TopoDS::Edge(edges_.FindKey(i)), copy = TopoDS::Edge(edges_(i));
    move_parameter_curves(copy, edge, surface);
    builder.SameRange(edge, BRep_Tool::SameRange(edge) && BRep_Tool::SameRange(copy));
    builder.SameParameter(edge, BRep_Tool::SameParameter(edge) && BRep_Tool::SameParameter(copy));
    builder.UpdateEdge(edge, BRep_Tool::Tolerance(copy));
    for (TopoDS_Iterator vertex(edge); vertex.More(); vertex.Next())
      builder.UpdateVertex(TopoDS::Vertex(vertex.Value()), BRep_Tool::Tolerance(edge));
    back.Replace(copy, edge);
  }
  builder.UpdateFace(original_, BRep_Tool::Tolerance(fixed_));
  if (surface == BRep_Tool::Surface(original_) && has_same_parts(original_, fixed_, edges_)) return;
  context.Replace(original_, back.Apply(fixed_).Oriented(TopAbs_FORWARD));
}

}  // namespace tetloom::cad
