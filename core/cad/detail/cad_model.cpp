#include "core/cad/detail/cad_model.hpp"

#include <Bnd_Box.hxx>
#include <BRep_Tool.hxx>
#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>

#include "core/base/assert.hpp"
#include "core/cad/detail/cad_edge.hpp"
#include "core/cad/detail/cad_face.hpp"
#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/occt_guard.hpp"

namespace tetloom::cad {
namespace {

Box3 compute_box(const TopoDS_Shape& root) {
  Bnd_Box box;
  BRepBndLib::AddOptimal(root, box, false, false);
  if (box.IsVoid()) throw Error(ErrorCode::InputUnsuitable, "the model has no extent");
  if (box.IsOpen()) throw Error(ErrorCode::InputUnsuitable, "the model is infinite");
  box.SetGap(0);
  Box3 result;
  result.add(to_vec3(box.CornerMin()));
  result.add(to_vec3(box.CornerMax()));
  return result;
}

}  // namespace

CadModel::CadModel(ShapeTopology parts, const TopoDS_Shape& root, const AttributeMap& attributes,
                   double metres_per_unit)
    : shapes_(std::move(parts.shapes)) {
  topology_ = std::move(parts.topology);
  attributes_ = make_entity_attributes(root, attributes, shapes_);
  metres_per_unit_ = metres_per_unit;
  translate_failures({}, ErrorCode::InputUnsuitable, "the bounding box", [&] { bounding_box_ = compute_box(root); });
  for (std::size_t i = 0; i < topology_.vertex_count; ++i) bounding_box_.add(vertex_point(ModelVertexId(i)));
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
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(shapes_.face(id), properties);
    return properties.Mass();
  });
}

double CadModel::volume(ModelRegionId id) const {
  TETLOOM_ASSERT(id.value < topology_.region_count());
  return translate_failures(named(id), ErrorCode::VolumeFailed, "the volume", [&] {
    GProp_GProps properties;
    BRepGProp::VolumeProperties(shapes_.solid(id), properties);
    return properties.Mass();
  });
}

}  // namespace tetloom::cad
