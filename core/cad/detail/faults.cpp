#include "core/cad/detail/faults.hpp"

#include <algorithm>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BRepAdaptor_Curve.hxx>
#include <BRepCheck_ListOfStatus.hxx>
#include <BRepCheck_Result.hxx>
#include <map>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>

#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/validity.hpp"

namespace tetloom::cad {
namespace {

constexpr std::size_t kMostWarnings = 200;

const char* text_of(BRepCheck_Status status) {
  switch (status) {
    case BRepCheck_InvalidPointOnCurve: return "a vertex lies off its curve";
    case BRepCheck_InvalidPointOnCurveOnSurface: return "a vertex lies off a parameter curve";
    case BRepCheck_InvalidPointOnSurface: return "a vertex lies off the surface";
    case BRepCheck_No3DCurve: return "it has no curve in space";
    case BRepCheck_Multiple3DCurve: return "it has several curves in space";
    case BRepCheck_Invalid3DCurve: return "its curve in space is invalid";
    case BRepCheck_NoCurveOnSurface: return "an edge has no parameter curve";
    case BRepCheck_InvalidCurveOnSurface: return "a parameter curve lies off its edge";
    case BRepCheck_InvalidCurveOnClosedSurface: return "the parameter curves of a seam are invalid";
    case BRepCheck_InvalidSameRangeFlag: return "a parameter curve has another range than its edge";
    case BRepCheck_InvalidSameParameterFlag: return "a parameter curve runs unlike its edge";
    case BRepCheck_InvalidDegeneratedFlag: return "an edge is degenerate and should not be, or the reverse";
    case BRepCheck_FreeEdge: return "an edge is free";
    case BRepCheck_InvalidMultiConnexity: return "too many faces meet in an edge";
    case BRepCheck_InvalidRange: return "its parameter range is invalid";
    case BRepCheck_EmptyWire: return "a wire is empty";
    case BRepCheck_RedundantEdge: return "an edge bounds the face more than once";
    case BRepCheck_SelfIntersectingWire: return "its boundary crosses itself";
    case BRepCheck_NoSurface: return "it has no surface";
    case BRepCheck_InvalidWire: return "a wire is invalid";
    case BRepCheck_RedundantWire: return "a wire appears twice";
    case BRepCheck_IntersectingWires: return "its wires cross each other";
    case BRepCheck_InvalidImbricationOfWires: return "its wires are nested wrongly";
    case BRepCheck_EmptyShell: return "a shell is empty";
    case BRepCheck_RedundantFace: return "a face appears twice";
    case BRepCheck_InvalidImbricationOfShells: return "its shells are nested wrongly";
    case BRepCheck_UnorientableShape: return "its boundary cannot be oriented";
    case BRepCheck_NotClosed: return "it is not closed";
    case BRepCheck_NotConnected: return "it is not connected";
    case BRepCheck_SubshapeNotInShape: return "a part of it is missing";
    case BRepCheck_BadOrientation: return "its orientation is wrong";
    case BRepCheck_BadOrientationOfSubshape: return "the orientation of a part of it is wrong";
    case BRepCheck_InvalidPolygonOnTriangulation: return "a stored polygon is invalid";
    case BRepCheck_InvalidToleranceValue: return "its tolerance is invalid";
    case BRepCheck_EnclosedRegion: return "it encloses a region of no solid";
    case BRepCheck_CheckFail: return "the check itself failed";
    default: return "it is invalid";
  }
}

/// Calls visit(shape, context or null, status) for every fault in a shape and everything inside.
template <class Visit>
void for_each_fault(const BRepCheck_Analyzer& analyzer, const TopoDS_Shape& shape, const Visit& visit) {
  TopTools_IndexedMapOfShape all;
  TopExp::MapShapes(shape, all);
  for (int i = 1; i <= all.Extent(); ++i) {
    const Handle(BRepCheck_Result)& result = analyzer.Result(all(i));
    if (result.IsNull()) continue;
    for (const BRepCheck_Status status : result->Status())
      if (status != BRepCheck_NoError) visit(all(i), TopoDS_Shape(), status);
    for (result->InitContextIterator(); result->MoreShapeInContext(); result->NextShapeInContext())
      for (const BRepCheck_Status status : result->StatusOnShape())
        if (status != BRepCheck_NoError) visit(all(i), result->ContextualShape(), status);
  }
}

gp_Pnt middle_of(const TopoDS_Edge& edge) {
  if (BRep_Tool::Degenerated(edge)) return BRep_Tool::Pnt(TopExp::FirstVertex(edge));
  const BRepAdaptor_Curve curve(edge);
  return curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()));
}

std::optional<Vec3> point_of(const TopoDS_Shape& shape) {
  if (shape.ShapeType() == TopAbs_VERTEX) return to_vec3(BRep_Tool::Pnt(TopoDS::Vertex(shape)));
  if (shape.ShapeType() == TopAbs_EDGE) return to_vec3(middle_of(TopoDS::Edge(shape)));
  for (TopExp_Explorer edge(shape, TopAbs_EDGE); edge.More(); edge.Next())
    return to_vec3(middle_of(TopoDS::Edge(edge.Current())));
  return std::nullopt;
}

ModelEntity entity_of(const TopoDS_Shape& shape, const ShapeTables& shapes) {
  const auto look_up = [&](const TopTools_IndexedMapOfShape& map, int dim) {
    const int index = map.FindIndex(shape);
    return index > 0 ? ModelEntity(dim, static_cast<std::uint32_t>(index - 1)) : ModelEntity();
  };
  switch (shape.ShapeType()) {
    case TopAbs_VERTEX: return look_up(shapes.vertices, 0);
    case TopAbs_EDGE: return look_up(shapes.edges, 1);
    case TopAbs_FACE: return look_up(shapes.faces, 2);
    case TopAbs_SOLID: return look_up(shapes.solids, 3);
    default: return {};
  }
}

/// The invalid entities, each with its reasons, in the order of dimension and id.
class FaultList {
 public:
  explicit FaultList(const ShapeTables& shapes) : shapes_(shapes) {}

  // A fault in the context of a face or solid is that one's; the shape itself says where.
  void add(const TopoDS_Shape& shape, const TopoDS_Shape& context, BRepCheck_Status status) {
    const ModelEntity own = entity_of(shape, shapes_);
    const ModelEntity around = context.IsNull() ? ModelEntity() : entity_of(context, shapes_);
    const ModelEntity chief = around.valid() ? around : own;
    if (!chief.valid()) return;
    Diagnostic& fault = faults_[{-int{chief.dim}, chief.index}];
    const char* text = text_of(status);
    if (fault.entities.empty()) {
      fault.code = ErrorCode::InputUnsuitable;
      fault.entities.push_back({chief, ""});
      fault.message = std::string("the shape is invalid: ") + text;
    } else if (fault.message.find(text) == std::string::npos) {
      fault.message += std::string("; ") + text;
    }
    if (own.valid() && own != chief) add_entity(fault, own);
    if (!fault.point || own != chief) fault.point = point_of(shape);
  }

  std::vector<Diagnostic> take() {
    std::vector<Diagnostic> result;
    for (auto& [key, fault] : faults_) {
      if (result.size() == kMostWarnings) {
        result.push_back({ErrorCode::InputUnsuitable,
                          std::to_string(faults_.size() - kMostWarnings) + " more entities are invalid",
                          {},
                          {},
                          {}});
        break;
      }
      result.push_back(std::move(fault));
    }
    return result;
  }

 private:
  static void add_entity(Diagnostic& fault, ModelEntity entity) {
    for (const NamedEntity& known : fault.entities)
      if (known.entity == entity) return;
    fault.entities.push_back({entity, ""});
  }

  const ShapeTables& shapes_;
  std::map<std::pair<int, std::uint32_t>, Diagnostic> faults_;
};

void warn_of_open_edges(const TopoDS_Shape& shape, const ShapeTables& shapes, const char* message,
                        std::vector<Diagnostic>& warnings) {
  const std::vector<TopoDS_Edge> open = find_open_edges(shape);
  if (open.empty()) return;
  Diagnostic warning{ErrorCode::OpenShell, message, {}, to_vec3(middle_of(open.front())), {}};
  if (const ModelEntity region = entity_of(shape, shapes); region.valid()) warning.entities.push_back({region, ""});
  constexpr std::size_t most_edges = 8;
  for (std::size_t i = 0; i < std::min(open.size(), most_edges); ++i)
    warning.entities.push_back({entity_of(open[i], shapes), ""});
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) {
    TopTools_IndexedMapOfShape edges;
    TopExp::MapShapes(face.Current(), TopAbs_EDGE, edges);
    if (!edges.Contains(open.front())) continue;
    warning.entities.push_back({entity_of(face.Current(), shapes), ""});
    break;
  }
  warnings.push_back(std::move(warning));
}

bool has_offset_surfaces(const TopoDS_Shape& shape) {
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
    if (has_offset_surface(TopoDS::Face(face.Current()))) return true;
  return false;
}

}  // namespace

std::unique_ptr<BRepCheck_Analyzer> analyze(const TopoDS_Shape& shape, const BlockLoop& loop) {
  std::unique_ptr<BRepCheck_Analyzer> result;
  const bool parallel = &loop != &serial_loop() && !has_offset_surfaces(shape);
  // As one block of the loop: what OpenCASCADE hands to oneTBB stays on the threads of its owner.
  loop.for_blocks(
      1, 1, [&](std::size_t, std::size_t) { result = std::make_unique<BRepCheck_Analyzer>(shape, true, parallel); });
  return result;
}

std::size_t count_faults(const BRepCheck_Analyzer& analyzer, const TopoDS_Shape& shape) {
  std::size_t count = 0;
  for_each_fault(analyzer, shape, [&](const TopoDS_Shape&, const TopoDS_Shape&, BRepCheck_Status) { ++count; });
  return count;
}

std::vector<TopoDS_Edge> find_open_edges(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape edges;
  std::vector<int> uses;
  for (TopExp_Explorer face(shape.Oriented(TopAbs_FORWARD), TopAbs_FACE); face.More(); face.Next()) {
    for (TopExp_Explorer edge(face.Current(), TopAbs_EDGE); edge.More(); edge.Next()) {
      const std::size_t index = static_cast<std::size_t>(edges.Add(edge.Current()));
      if (index > uses.size()) uses.resize(index, 0);
      const TopAbs_Orientation orientation = edge.Current().Orientation();
      const bool both_sides = orientation == TopAbs_INTERNAL || face.Current().Orientation() == TopAbs_INTERNAL;
      uses[index - 1] += both_sides ? 2 : 1;
    }
  }
  std::vector<TopoDS_Edge> open;
  for (std::size_t i = 0; i < uses.size(); ++i) {
    const TopoDS_Edge edge = TopoDS::Edge(edges(static_cast<int>(i) + 1));
    if (uses[i] == 1 && !BRep_Tool::Degenerated(edge)) open.push_back(edge);
  }
  return open;
}

std::vector<Diagnostic> describe_faults(const std::vector<TopoDS_Shape>& bodies, const ShapeTables& shapes,
                                        const BlockLoop& loop) {
  TopoDS_Compound root;
  BRep_Builder builder;
  builder.MakeCompound(root);
  for (const TopoDS_Shape& body : bodies) builder.Add(root, body);
  FaultList faults(shapes);
  const auto analyzer = analyze(root, loop);
  if (analyzer->IsValid()) return {};
  for_each_fault(*analyzer, root, [&](const TopoDS_Shape& shape, const TopoDS_Shape& context, BRepCheck_Status status) {
    faults.add(shape, context, status);
  });
  return faults.take();
}

std::vector<Diagnostic> describe_open_shells(const TopoDS_Shape& root, const ShapeTables& shapes) {
  std::vector<Diagnostic> warnings;
  TopTools_IndexedMapOfShape inner;
  for (int i = 1; i <= shapes.solids.Extent(); ++i) {
    warn_of_open_edges(shapes.solids(i), shapes, "the boundary of a region is open", warnings);
    TopExp::MapShapes(shapes.solids(i), TopAbs_FACE, inner);
  }
  for (TopExp_Explorer shell(root, TopAbs_SHELL, TopAbs_SOLID); shell.More(); shell.Next()) {
    const TopExp_Explorer face(shell.Current(), TopAbs_FACE);
    if (face.More() && !inner.Contains(face.Current()))
      warn_of_open_edges(shell.Current(), shapes, "an open shell is meshed as a sheet", warnings);
  }
  return warnings;
}

}  // namespace tetloom::cad
