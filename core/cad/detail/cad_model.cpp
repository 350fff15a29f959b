#include "core/cad/detail/cad_model.hpp"

#include <algorithm>
#include <Bnd_Box.hxx>
#include <BRep_Tool.hxx>
#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>
#include <utility>
#include <vector>

#include "core/cad/detail/cad_edge.hpp"
#include "core/cad/detail/cad_face.hpp"
#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/occt_guard.hpp"
#include "tetloom/assert.hpp"

namespace tetloom::cad {
namespace {

Box3 to_box3(Bnd_Box box) {
  if (box.IsVoid()) return {};
  if (box.IsOpen()) throw Error(ErrorCode::InputUnsuitable, "the model is infinite");
  box.SetGap(0);
  Box3 result;
  result.add(to_vec3(box.CornerMin()));
  result.add(to_vec3(box.CornerMax()));
  return result;
}

bool covers(const Box3& outer, const Box3& inner) { return outer.contains(inner.lo) && outer.contains(inner.hi); }

/// How far `inner` sticks out of `outer`; 0 where that covers it.
double overhang(const Box3& outer, const Box3& inner) {
  double most = 0;
  for (int axis = 0; axis < 3; ++axis)
    most = std::max({most, outer.lo[axis] - inner.lo[axis], inner.hi[axis] - outer.hi[axis]});
  return most;
}

Box3 loose_box(const TopoDS_Face& face) {
  Bnd_Box box;
  BRepBndLib::Add(face, box, false);
  return to_box3(box);
}

Box3 tight_box(const TopoDS_Face& face) {
  Bnd_Box box;
  BRepBndLib::AddOptimal(face, box, false, false);
  return to_box3(box);
}

/// The tight box of a face costs an optimisation; most faces lie inside the box of the others anyway, the more so when
/// those that may stick out farthest come first.
Box3 compute_box(const ShapeTables& shapes, std::size_t face_count) {
  Box3 result;
  for (int i = 1; i <= shapes.vertices.Extent(); ++i)
    result.add(to_vec3(BRep_Tool::Pnt(shapes.vertex(ModelVertexId(static_cast<std::size_t>(i - 1))))));
  std::vector<Box3> loose;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < face_count; ++i) {
    loose.push_back(loose_box(shapes.face(ModelFaceId(i))));
    order.emplace_back(-overhang(result, loose.back()), i);
  }
  std::sort(order.begin(), order.end());
  for (const auto& [unused, i] : order)
    if (!covers(result, loose[i])) result.add(tight_box(shapes.face(ModelFaceId(i))));
  if (result.empty()) throw Error(ErrorCode::InputUnsuitable, "the model has no extent");
  return result;
}

/// Places at which a parameter curve is compared with its edge, and what is added for the places between.
constexpr int kToleranceSamples = 40;
constexpr double kToleranceMargin = 1.25;

}  // namespace

CadModel::CadModel(ShapeTopology parts, const TopoDS_Shape& root, const AttributeMap& attributes,
                   double metres_per_unit)
    : shapes_(std::move(parts.shapes)), areas_(parts.topology.face_count()), volumes_(parts.topology.region_count()) {
  topology_ = std::move(parts.topology);
  attributes_ = make_entity_attributes(root, attributes, shapes_);
  metres_per_unit_ = metres_per_unit;
  translate_failures({}, ErrorCode::InputUnsuitable, "the bounding box",
                     [&] { bounding_box_ = compute_box(shapes_, topology_.face_count()); });
  measure_tolerances();
}

// Files understate how far parameter curves lie off their edges, and vertices off both.
void CadModel::measure_tolerances() {
  for (std::size_t i = 0; i < topology_.face_count(); ++i) {
    try {
      const auto face = face_geometry(ModelFaceId(i));
      for (const ModelLoop& loop : topology_.face_to_loops[i]) {
        for (const EdgeUse& use : loop) {
          if (topology_.edges[use.edge.value].degenerate) continue;
          const auto edge = edge_geometry(use.edge);
          measure_use(*face, *edge, use);
        }
      }
    } catch (const Error& error) {  // whoever meshes this face gets the same error, with its place
      if (error.code() == ErrorCode::OutOfMemory) throw;
    }
  }
}

void CadModel::measure_use(FaceGeometry& face, EdgeGeometry& edge, const EdgeUse& use) {
  const auto raise = [&](ModelEntity entity, double gap) {
    double& tolerance = attributes_[entity.dim][entity.index].tolerance;
    if (gap > tolerance) tolerance = kToleranceMargin * gap;
  };
  const ParameterRange range = face.edge_range(use);
  for (int i = 0; i <= kToleranceSamples; ++i) {
    const double t = range.lo + (range.hi - range.lo) * i / kToleranceSamples;
    const Vec3 on_edge = edge.evaluate(t), on_face = face.evaluate(face.edge_parameters(use, t));
    raise(use.edge, distance(on_edge, on_face));
    if (i > 0 && i < kToleranceSamples) continue;
    const ModelVertexId vertex = topology_.edges[use.edge.value].vertices[i == 0 ? 0 : 1];
    const Vec3 at = vertex_point(vertex);
    raise(vertex, std::max(distance(at, on_edge), distance(at, on_face)));
  }
}

Vec3 CadModel::vertex_point(ModelVertexId id) const {
  TETLOOM_ASSERT(id.value < topology_.vertex_count);
  return to_vec3(BRep_Tool::Pnt(shapes_.vertex(id)));
}

std::unique_ptr<EdgeGeometry> CadModel::edge_geometry(ModelEdgeId id) const {
  TETLOOM_ASSERT(id.value < topology_.edge_count());
  return std::make_unique<CadEdge>(shapes_.edge(id), named(id));
}

std::unique_ptr<FaceGeometry> CadModel::face_geometry(ModelFaceId id) const {
  TETLOOM_ASSERT(id.value < topology_.face_count());
  return std::make_unique<CadFace>(shapes_, topology_, id, named(id));
}

double CadModel::area(ModelFaceId id) const {
  TETLOOM_ASSERT(id.value < topology_.face_count());
  return translate_failures(named(id), ErrorCode::FaceFailed, "the area", [&] {
    return areas_.get(id.value, [&] {
      GProp_GProps properties;
      BRepGProp::SurfaceProperties(shapes_.face(id), properties);
      return properties.Mass();
    });
  });
}

double CadModel::volume(ModelRegionId id) const {
  TETLOOM_ASSERT(id.value < topology_.region_count());
  return translate_failures(named(id), ErrorCode::VolumeFailed, "the volume", [&] {
    // Adaptive integration: with the fixed number of Gauss points of the plain call, solids of spline faces come out
    // wrong by up to two percent.
    constexpr double kRelativeError = 1e-4;
    return volumes_.get(id.value, [&] {
      GProp_GProps properties;
      BRepGProp::VolumeProperties(shapes_.solid(id), properties, kRelativeError);
      return properties.Mass();
    });
  });
}

}  // namespace tetloom::cad
