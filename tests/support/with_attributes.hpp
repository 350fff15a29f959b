#pragma once
// A model of which the attributes can be changed.
#include <cstddef>
#include <memory>
#include <utility>

#include "tetloom/model.hpp"

namespace tetloom::test_models {

/// A model with the shape of another and attributes of its own.
class WithAttributes final : public GeometricModel {
 public:
  explicit WithAttributes(std::unique_ptr<GeometricModel> model) : model_(std::move(model)) {
    topology_ = model_->topology();
    for (int dim = 0; dim < 4; ++dim) attributes_[static_cast<std::size_t>(dim)].resize(topology_.count(dim));
    bounding_box_ = model_->bounding_box();
  }
  EntityAttributes& change(int dim, std::size_t index) { return attributes_[static_cast<std::size_t>(dim)][index]; }
  Vec3 vertex_point(ModelVertexId id) const override { return model_->vertex_point(id); }
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override { return model_->edge_geometry(id); }
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override { return model_->face_geometry(id); }
  double area(ModelFaceId id) const override { return model_->area(id); }
  double volume(ModelRegionId id) const override { return model_->volume(id); }

 private:
  std::unique_ptr<GeometricModel> model_;
};

}  // namespace tetloom::test_models
