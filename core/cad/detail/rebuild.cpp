#include "core/cad/detail/rebuild.hpp"

#include <algorithm>
#include <BOPAlgo_MakerVolume.hxx>
#include <BOPTools_AlgoTools3D.hxx>
#include <BRep_Builder.hxx>
#include <BRepClass3d_SolidClassifier.hxx>
#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>
#include <IntTools_Context.hxx>
#include <optional>
#include <ShapeBuild_ReShape.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopTools_DataMapOfShapeListOfShape.hxx>

#include "core/cad/detail/faults.hpp"
#include "core/cad/detail/healing.hpp"
#include "core/cad/detail/occt_guard.hpp"

namespace tetloom::cad {
namespace {

std::vector<TopoDS_Shape> list_shapes(const TopoDS_Shape& shape, TopAbs_ShapeEnum type) {
  TopTools_IndexedMapOfShape map;
  TopExp::MapShapes(shape, type, map);
  std::vector<TopoDS_Shape> result;
  for (int i = 1; i <= map.Extent(); ++i) result.push_back(map(i));
  return result;
}

double volume_of(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties);
  return properties.Mass();
}

/// A little below the middle of one of the cell's faces.
std::optional<gp_Pnt> point_inside(const TopoDS_Shape& cell) {
  constexpr double kDepth = 1e-3;  // of the cube root of the volume
  const double depth = kDepth * std::cbrt(std::abs(volume_of(cell)));
  const Handle(IntTools_Context) context = new IntTools_Context;
  BRepClass3d_SolidClassifier classifier(cell);
  for (const TopoDS_Shape& shape : list_shapes(cell, TopAbs_FACE)) {
    gp_Pnt point;
    gp_Pnt2d uv;
    const TopoDS_Face face = TopoDS::Face(shape);
    if (BOPTools_AlgoTools3D::PointInFace(face, point, uv, context) != 0) continue;
    gp_Dir normal;
    if (!BOPTools_AlgoTools3D::GetNormalToSurface(BRep_Tool::Surface(face), uv.X(), uv.Y(), normal)) continue;
    for (const double sign : {1.0, -1.0}) {
      const gp_Pnt below = point.Translated(sign * depth * gp_Vec(normal));
      classifier.Perform(below, Precision::Confusion());
      if (classifier.State() == TopAbs_IN) return below;
    }
  }
  return {};
}

class Rebuilder {
 public:
  explicit Rebuilder(const CancelToken* cancel) : cancel_(cancel) {}

  /// Null where there is nothing better than the old body.
  TopoDS_Shape rebuild(const TopoDS_Shape& body) {
    BOPAlgo_MakerVolume maker;
    TopTools_ListOfShape faces;
    for (const TopoDS_Shape& face : list_shapes(body, TopAbs_FACE)) faces.Append(face);
    maker.SetArguments(faces);
    maker.SetIntersect(true);
    maker.SetAvoidInternalShapes(true);
    maker.SetRunParallel(false);
    maker.SetNonDestructive(true);
    Handle(CancelIndicator) indicator = new CancelIndicator(cancel_);
    maker.Perform(Message_ProgressIndicator::Start(indicator));
    if (cancel_) cancel_->check();
    if (maker.HasErrors() || maker.Shape().IsNull()) return {};
    const TopoDS_Shape result = join(cells_inside(maker.Shape(), body));
    if (!result.IsNull()) remember(maker, faces);
    return result;
  }

  std::vector<TopoDS_Shape> successors(const TopoDS_Shape& face) const {
    std::vector<TopoDS_Shape> result;
    if (const TopTools_ListOfShape* found = history_.Seek(face))
      for (const TopoDS_Shape& next : *found) result.push_back(next);
    return result;
  }
  bool knows(const TopoDS_Shape& face) const { return history_.IsBound(face); }

 private:
  std::vector<TopoDS_Shape> cells_inside(const TopoDS_Shape& cells, const TopoDS_Shape& body) const {
    std::vector<TopoDS_Shape> inside;
    BRepClass3d_SolidClassifier classifier(body);
    for (const TopoDS_Shape& cell : list_shapes(cells, TopAbs_SOLID)) {
      if (cancel_) cancel_->check();
      if (!(volume_of(cell) > 0) || !find_open_edges(cell).empty()) continue;
      const std::optional<gp_Pnt> point = point_inside(cell);
      if (!point) continue;
      classifier.Perform(*point, Precision::Confusion());
      if (classifier.State() == TopAbs_IN) inside.push_back(cell);
    }
    return inside;
  }

  static TopoDS_Shape join(const std::vector<TopoDS_Shape>& cells) {
    if (cells.size() < 2) return cells.empty() ? TopoDS_Shape() : cells.front();
    TopoDS_Compound result;
    BRep_Builder builder;
    builder.MakeCompound(result);
    for (const TopoDS_Shape& cell : cells) builder.Add(result, cell);
    return result;
  }

  void remember(BOPAlgo_MakerVolume& maker, const TopTools_ListOfShape& faces) {
    for (const TopoDS_Shape& face : faces) {
      TopTools_ListOfShape next;
      if (!maker.IsDeleted(face)) next = maker.Modified(face);
      if (next.IsEmpty() && !maker.IsDeleted(face)) next.Append(face);
      history_.Bind(face, next);
    }
  }

  const CancelToken* cancel_;
  TopTools_DataMapOfShapeListOfShape history_;
};

}  // namespace

std::size_t rebuild_solids(Document& document, const std::vector<ModelRegionId>& solids, const CancelToken* cancel) {
  const std::vector<TopoDS_Shape> all = list_shapes(document.root, TopAbs_SOLID);
  const Handle(ShapeBuild_ReShape) context = new ShapeBuild_ReShape;
  context->ModeConsiderLocation() = true;  // wherever the body is placed
  Rebuilder rebuilder(cancel);
  std::size_t count = 0;
  for (const ModelRegionId id : solids) {
    if (id.value >= all.size()) continue;
    const TopoDS_Shape body = all[id.value].Located(TopLoc_Location());
    const TopoDS_Shape rebuilt = rebuilder.rebuild(body);
    if (rebuilt.IsNull()) continue;
    context->Replace(body, rebuilt);
    ++count;
  }
  if (count == 0) return 0;
  const TopoDS_Shape root = context->Apply(document.root);
  replace_shapes(document, root, [&](const TopoDS_Shape& shape) {
    const TopoDS_Shape local = shape.Located(TopLoc_Location());
    if (shape.ShapeType() == TopAbs_FACE && rebuilder.knows(local)) {
      std::vector<TopoDS_Shape> next = rebuilder.successors(local);
      for (TopoDS_Shape& face : next) face.Move(shape.Location());
      return next;
    }
    const TopoDS_Shape next = context->Apply(shape);
    if (next.IsNull()) return std::vector<TopoDS_Shape>{};
    if (next.ShapeType() == shape.ShapeType()) return std::vector<TopoDS_Shape>{next};
    return list_shapes(next, shape.ShapeType());
  });
  return count;
}

}  // namespace tetloom::cad
