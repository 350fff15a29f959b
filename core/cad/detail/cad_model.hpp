#pragma once
// An OpenCASCADE shape as a GeometricModel. Private to core/cad.
#include <memory>
#include <mutex>
#include <vector>

#include "core/cad/detail/cad_face.hpp"
#include "core/cad/detail/document.hpp"
#include "core/cad/detail/face_integrals.hpp"
#include "core/cad/detail/shape_attributes.hpp"
#include "core/cad/detail/topology.hpp"
#include "tetloom/host.hpp"

namespace tetloom::cad {

/// Values that are dear to compute, each found when it is first asked for. Thread safety: any number of threads.
template <class Value>
class LazyValues {
 public:
  explicit LazyValues(std::size_t count) : found_(new std::once_flag[count]), values_(count) {}
  /// What `compute` throws reaches the caller, and the next one computes again.
  template <class Compute>
  const Value& get(std::size_t i, const Compute& compute) const {
    std::call_once(found_[i], [&] { values_[i] = compute(); });
    return values_[i];
  }

 private:
  std::unique_ptr<std::once_flag[]> found_;
  mutable std::vector<Value> values_;
};

/// A document's shapes as a model.
class CadModel final : public GeometricModel {
 public:
  /// Takes over the shapes of a document and their tables. Errors: InputUnsuitable.
  CadModel(ShapeTopology parts, Document document, const BlockLoop& loop);

  Vec3 vertex_point(ModelVertexId id) const override;
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override;
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override;
  double area(ModelFaceId id) const override;
  FacePlace place(ModelFaceId id) const override;
  double volume(ModelRegionId id) const override;
  const ShapeTables& shapes() const { return shapes_; }
  const Document& document() const { return document_; }

 private:
  const FaceIntegrals& integrals(ModelFaceId id) const;
  struct Gap {
    ModelEntity entity;
    double width;
  };
  void measure_tolerances(const BlockLoop& loop);
  std::vector<Gap> measure_face(ModelFaceId id) const;
  void measure_use(FaceGeometry& face, EdgeGeometry& edge, const EdgeUse& use, std::vector<Gap>& gaps) const;

  Document document_;
  ShapeTables shapes_;
  std::vector<std::uint32_t> face_to_shape_;          ///< the first face of the same shape
  LazyValues<std::unique_ptr<const CadFace>> faces_;  ///< those that others are copied from
  LazyValues<FaceIntegrals> integrals_;               ///< of faces
  LazyValues<double> volumes_;
};

}  // namespace tetloom::cad
