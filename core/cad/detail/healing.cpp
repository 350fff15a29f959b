#include "core/cad/detail/healing.hpp"

#include <algorithm>

#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BRepAdaptor_Curve.hxx>
#include <BRepLib.hxx>
#include <BRepTools_PurgeLocations.hxx>
#include <GCPnts_AbscissaPoint.hxx>
#include <Geom_Plane.hxx>
#include <Precision.hxx>
#include <ShapeBuild_ReShape.hxx>
#include <ShapeFix_Edge.hxx>
#include <ShapeFix_Shape.hxx>
#include <ShapeFix_Wireframe.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>

#include "core/cad/detail/face_integrals.hpp"
#include "core/cad/detail/faults.hpp"
#include "core/cad/detail/occt_guard.hpp"
#include "core/cad/detail/stray_curves.hpp"
#include "core/cad/detail/validity.hpp"

namespace tetloom::cad {

void add_step(std::vector<HealingStep>& steps, const char* what, std::size_t count) {
  if (count > 0) steps.push_back({what, count});
}

void replace_shapes(Document& document, const TopoDS_Shape& root, const ShapeSuccessors& successors) {
  document.attributes = transfer_attributes(document.attributes, successors);
  if (root.ShapeType() == TopAbs_COMPOUND) {
    document.root = TopoDS::Compound(root);
    return;
  }
  BRep_Builder().MakeCompound(document.root);
  BRep_Builder().Add(document.root, root);
}

namespace {

/// The shapes of one type inside, each once, in the order of TopExp.
std::vector<TopoDS_Shape> shapes_of(const TopoDS_Shape& root, TopAbs_ShapeEnum type,
                                    TopAbs_ShapeEnum avoid = TopAbs_SHAPE) {
  TopTools_IndexedMapOfShape map;
  for (TopExp_Explorer explorer(root, type, avoid); explorer.More(); explorer.Next()) map.Add(explorer.Current());
  std::vector<TopoDS_Shape> result;
  for (int i = 1; i <= map.Extent(); ++i) result.push_back(map(i));
  return result;
}

std::size_t remove_scaled_locations(Document& document) {
  bool needed = false;
  TopTools_IndexedMapOfShape all;
  TopExp::MapShapes(document.root, all);
  for (int i = 1; i <= all.Extent() && !needed; ++i) {
    const gp_Trsf transform = all(i).Location().Transformation();
    needed = transform.IsNegative() || std::abs(std::abs(transform.ScaleFactor()) - 1) > TopLoc_Location::ScalePrec();
  }
  if (!needed) return 0;
  BRepTools_PurgeLocations purge;
  if (!purge.Perform(document.root)) return 0;
  const TopoDS_Shape root = purge.GetResult();
  replace_shapes(document, root,
                 [&](const TopoDS_Shape& shape) -> std::vector<TopoDS_Shape> { return {purge.ModifiedShape(shape)}; });
  return 1;
}

std::size_t add_space_curves(const TopoDS_Shape& root) {
  std::size_t count = 0;
  for (const TopoDS_Shape& shape : shapes_of(root, TopAbs_EDGE)) {
    const TopoDS_Edge edge = TopoDS::Edge(shape);
    double first, last;
    if (BRep_Tool::Degenerated(edge) || !BRep_Tool::Curve(edge, first, last).IsNull()) continue;
    if (BRepLib::BuildCurve3d(edge)) ++count;
  }
  return count;
}

std::size_t add_parameter_curves(const TopoDS_Shape& root) {
  std::size_t count = 0;
  ShapeFix_Edge fix;
  for (const TopoDS_Shape& face_shape : shapes_of(root, TopAbs_FACE)) {
    const TopoDS_Face face = TopoDS::Face(face_shape.Oriented(TopAbs_FORWARD));
    for (const TopoDS_Shape& shape : shapes_of(face, TopAbs_EDGE)) {
      const TopoDS_Edge edge = TopoDS::Edge(shape);
      double first, last;
      if (!BRep_Tool::CurveOnSurface(edge, face, first, last).IsNull()) continue;
      const bool seam = BRep_Tool::IsClosed(edge, face);
      if (fix.FixAddPCurve(edge, face, seam)) ++count;
    }
  }
  return count;
}

std::size_t reparametrise(const TopoDS_Shape& root) {
  std::size_t count = 0;
  for (const TopoDS_Shape& shape : shapes_of(root, TopAbs_EDGE)) {
    const TopoDS_Edge edge = TopoDS::Edge(shape);
    if (BRep_Tool::Degenerated(edge) || BRep_Tool::SameParameter(edge)) continue;
    BRepLib::SameParameter(edge, BRep_Tool::Tolerance(edge));
    ++count;
  }
  return count;
}

/// A context that knows the replacement of every shape, in whatever place it stands.
using Context = Handle(ShapeBuild_ReShape);

Context make_context() {
  Context context = new ShapeBuild_ReShape;
  context->ModeConsiderLocation() = true;
  return context;
}

std::vector<TopoDS_Shape> successors_in(const Context& context, const TopoDS_Shape& shape) {
  const TopoDS_Shape next = context->Apply(shape);
  if (next.IsNull()) return {};
  if (next.ShapeType() == shape.ShapeType()) return {next};
  return shapes_of(next, shape.ShapeType());
}

void apply(Document& document, const Context& context) {
  const TopoDS_Shape root = context->Apply(document.root);
  replace_shapes(document, root, [&](const TopoDS_Shape& shape) { return successors_in(context, shape); });
}

std::size_t badness(const BRepCheck_Analyzer& analyzer, const TopoDS_Shape& shape) {
  return (analyzer.IsValid() ? 0 : count_faults(analyzer, shape)) + 1000 * find_open_edges(shape).size();
}

std::size_t badness(const TopoDS_Shape& shape, const BlockLoop& loop) { return badness(*analyze(shape, loop), shape); }

/// A repair must not change the shape itself by more than this share of its volume.
constexpr double kVolumeChange = 0.01;

bool keeps_volume(const TopoDS_Shape& before, const TopoDS_Shape& after, const BlockLoop& loop) {
  if (before.ShapeType() != TopAbs_SOLID) return true;
  if (!TopExp_Explorer(after, TopAbs_SOLID).More()) return false;
  KnownIntegrals known;
  const double old_volume = enclosed_volume(before, known, loop), new_volume = enclosed_volume(after, known, loop);
  return std::abs(std::abs(new_volume) - std::abs(old_volume)) <= kVolumeChange * std::abs(old_volume);
}

/// Each body on its own: what holds a valid body together is not touched.
std::size_t fix_bodies(const std::vector<TopoDS_Shape>& bodies, Document& document, const CancelToken* cancel,
                       const BlockLoop& loop) {
  std::size_t count = 0;
  for (const TopoDS_Shape& body : bodies) {
    if (cancel) cancel->check();
    const auto analyzer = analyze(body, loop);
    const std::size_t faults = badness(*analyzer, body);
    const Context context = make_context();
    const Handle(ShapeFix_Shape) fix = new ShapeFix_Shape(body);
    fix->SetContext(context);
    Handle(CancelIndicator) indicator = new CancelIndicator(cancel);
    fix->Perform(Message_ProgressIndicator::Start(indicator));
    if (cancel) cancel->check();
    const TopoDS_Shape fixed = context->Apply(body);
    if (fixed.IsNull() || badness(fixed, loop) >= faults || !keeps_volume(body, fixed, loop)) continue;
    apply(document, context);
    ++count;
  }
  return count;
}

double length_of(const TopoDS_Edge& edge) {
  const BRepAdaptor_Curve curve(edge);
  return GCPnts_AbscissaPoint::Length(curve);
}

std::size_t count_tiny_edges(const TopoDS_Shape& root, double length) {
  std::size_t count = 0;
  for (const TopoDS_Shape& shape : shapes_of(root, TopAbs_EDGE)) {
    const TopoDS_Edge edge = TopoDS::Edge(shape);
    TopoDS_Vertex first, last;
    TopExp::Vertices(edge, first, last);
    double lo, hi;
    if (first.IsNull() || last.IsNull() || BRep_Tool::Degenerated(edge)) continue;
    if (BRep_Tool::Curve(edge, lo, hi).IsNull()) continue;
    if (BRep_Tool::Pnt(first).Distance(BRep_Tool::Pnt(last)) > length) continue;
    if (length_of(edge) <= length) ++count;
  }
  return count;
}

/// Edges shorter than the precision of the kernel are points.
std::size_t remove_tiny_edges(Document& document, const BlockLoop& loop) {
  const double length = Precision::Confusion();
  const std::size_t before = count_tiny_edges(document.root, length);
  if (before == 0) return 0;
  const Context context = make_context();
  const Handle(ShapeFix_Wireframe) fix = new ShapeFix_Wireframe(document.root);
  fix->SetContext(context);
  fix->SetPrecision(length);
  fix->ModeDropSmallEdges() = true;
  fix->FixSmallEdges();
  const TopoDS_Shape root = context->Apply(document.root);
  if (root.IsNull() || badness(root, loop) > badness(document.root, loop)) return 0;
  const std::size_t after = count_tiny_edges(root, length);
  apply(document, context);
  return before - std::min(before, after);
}

std::size_t uses_of(const TopoDS_Shape& face, const TopoDS_Shape& edge) {
  std::size_t count = 0;
  for (TopExp_Explorer use(face, TopAbs_EDGE); use.More(); use.Next()) count += use.Current().IsSame(edge) ? 1 : 0;
  return count;
}

/// Lies the whole closed edge within the tolerance of its vertex?
bool is_within_vertex(const TopoDS_Edge& edge) {
  TopoDS_Vertex first, last;
  TopExp::Vertices(edge, first, last);
  double lo, hi;
  if (first.IsNull() || !first.IsSame(last) || BRep_Tool::Degenerated(edge)) return false;
  if (BRep_Tool::Curve(edge, lo, hi).IsNull()) return false;
  const BRepAdaptor_Curve curve(edge);
  constexpr int samples = 16;
  for (int i = 0; i <= samples; ++i)
    if (curve.Value(lo + (hi - lo) * i / samples).Distance(BRep_Tool::Pnt(first)) > BRep_Tool::Tolerance(first))
      return false;
  return true;
}

/// Edges that stick into a face and back, and that the tolerance of their vertex swallows.
std::size_t remove_swallowed_spurs(Document& document) {
  TopTools_IndexedDataMapOfShapeListOfShape edge_to_faces;
  TopExp::MapShapesAndAncestors(document.root, TopAbs_EDGE, TopAbs_FACE, edge_to_faces);
  const Context context = make_context();
  std::size_t count = 0;
  for (int i = 1; i <= edge_to_faces.Extent(); ++i) {
    const TopoDS_Edge edge = TopoDS::Edge(edge_to_faces.FindKey(i));
    if (!is_within_vertex(edge)) continue;
    TopTools_IndexedMapOfShape faces;
    for (const TopoDS_Shape& face : edge_to_faces(i)) faces.Add(face);
    if (faces.Extent() != 1 || uses_of(faces(1), edge) != 2) continue;
    context->Remove(edge);
    ++count;
  }
  if (count > 0) apply(document, context);
  return count;
}

double perimeter_of(const TopoDS_Shape& face) {
  double length = 0;
  for (const TopoDS_Shape& shape : shapes_of(face, TopAbs_EDGE)) {
    const TopoDS_Edge edge = TopoDS::Edge(shape);
    double lo, hi;
    if (!BRep_Tool::Degenerated(edge) && !BRep_Tool::Curve(edge, lo, hi).IsNull()) length += length_of(edge);
  }
  return length;
}

/// Narrower than its tolerance, on average.
bool is_collapsed(const TopoDS_Face& face) {
  const double width = std::max(BRep_Tool::Tolerance(face), Precision::Confusion());
  return std::abs(integrate_face(face).area) <= width * std::max(0.5 * perimeter_of(face), width);
}

/// Faces of no solid that are a line or a point: whatever is sewn to them would be a solid without volume.
std::size_t drop_collapsed_faces(Document& document) {
  const Context context = make_context();
  std::size_t count = 0;
  for (const TopoDS_Shape& shape : shapes_of(document.root, TopAbs_FACE, TopAbs_SOLID)) {
    if (!is_collapsed(TopoDS::Face(shape))) continue;
    context->Remove(shape);
    ++count;
  }
  if (count > 0) apply(document, context);
  return count;
}

/// The same solid with the orientation that it is stored with worked into its shells.
TopoDS_Solid with_own_orientation(const TopoDS_Solid& solid) {
  TopoDS_Solid result;
  BRep_Builder builder;
  builder.MakeSolid(result);
  for (TopoDS_Iterator shell(solid); shell.More(); shell.Next()) builder.Add(result, shell.Value());
  return result;
}

std::size_t turn_right_side_out(Document& document, const BlockLoop& loop) {
  const Context context = make_context();
  std::size_t count = 0;
  for (const TopoDS_Shape& original : shapes_of(document.root, TopAbs_SOLID)) {
    const TopoDS_Shape body = original.Located(TopLoc_Location());
    if (context->IsRecorded(body) || !(enclosed_volume(body, document.integrals, loop) < 0) ||
        !find_open_edges(body).empty())
      continue;
    TopoDS_Solid solid = TopoDS::Solid(body);
    if (!BRepLib::OrientClosedSolid(solid) || !(enclosed_volume(solid, document.integrals, loop) > 0)) continue;
    context->Replace(body, with_own_orientation(solid));
    ++count;
  }
  if (count > 0) apply(document, context);
  return count;
}

}  // namespace

void complete_geometry(Document& document, std::vector<HealingStep>& steps) {
  for (const TopoDS_Shape& face : shapes_of(document.root, TopAbs_FACE))
    if (BRep_Tool::Surface(TopoDS::Face(face)).IsNull())
      throw Error(ErrorCode::InputUnsuitable, "a face has no surface (facets alone cannot be meshed)");
  add_step(steps, "mirrored or scaled placements were worked into the geometry", remove_scaled_locations(document));
  const std::size_t in_space = add_space_curves(document.root), on_faces = add_parameter_curves(document.root);
  if (in_space + on_faces > 0) document.valid_bodies.Clear();
  add_step(steps, "edges got the curve in space that they lacked", in_space);
  add_step(steps, "edges got a parameter curve that they lacked", on_faces);
}

bool heal(Document& document, std::vector<HealingStep>& steps, const CancelToken* cancel, const BlockLoop& loop) {
  const std::size_t changed = reparametrise(document.root), fitted = repair_stray_curves(document.root);
  if (changed + fitted > 0) document.valid_bodies.Clear();
  add_step(steps, "edges were brought to one parameter with their parameter curves", changed);
  add_step(steps, "curves were fitted to the vertices that they missed", fitted);
  add_step(steps, "faces without area were left out", drop_collapsed_faces(document));
  sew_loose_faces(document, steps, cancel);
  add_step(steps, "edges within the tolerance of one vertex were removed", remove_swallowed_spurs(document));
  const std::vector<TopoDS_Shape> invalid = find_invalid_bodies(document, cancel, loop);
  const bool valid = invalid.empty();
  if (!valid) add_step(steps, "invalid solids or sheets were repaired", fix_bodies(invalid, document, cancel, loop));
  const std::size_t removed = remove_tiny_edges(document, loop), turned = turn_right_side_out(document, loop);
  add_step(steps, "edges without length were removed", removed);
  add_step(steps, "solids were turned right side out", turned);
  return valid && removed + turned == 0;
}

}  // namespace tetloom::cad
