#pragma once
// An OpenCASCADE shape as a GeometricModel. Private to core/cad.
#include "core/cad/detail/shape_attributes.hpp"
#include "core/cad/detail/topology.hpp"

namespace tetloom::cad {

class CadModel final : public GeometricModel {
 public:
  /// Takes over the shapes and their tables. Errors: InputUnsuitable.
  CadModel(ShapeTopology parts, const TopoDS_Shape& root, const AttributeMap& attributes, double metres_per_unit);

  Vec3 vertex_point(ModelVertexId id) const override;
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override;
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override;
  double area(ModelFaceId id) const override;
  double volume(ModelRegionId id) const override;
  const ShapeTables& shapes() const { return shapes_; }

 private:
  void measure_tolerances();
  void measure_use(FaceGeometry& face, EdgeGeometry& edge, const EdgeUse& use);

  ShapeTables shapes_;
};

}  // namespace tetloom::cad
