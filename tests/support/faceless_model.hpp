#pragma once
// A model of which the surfaces cannot be asked.
#include <memory>
#include <utility>

#include "tetloom/model.hpp"

namespace tetloom::test_models {

/// The given model, whose faces refuse every question with an error of the given code.
class FacelessModel final : public GeometricModel {
 public:
  FacelessModel(std::unique_ptr<GeometricModel> model, ErrorCode code) : code_(code), model_(std::move(model)) {
    topology_ = model_->topology();
    bounding_box_ = model_->bounding_box();
    attributes_[0].resize(topology_.vertex_count);
    attributes_[1].resize(topology_.edge_count());
    attributes_[2].resize(topology_.face_count());
    attributes_[3].resize(topology_.region_count());
  }
  Vec3 vertex_point(ModelVertexId id) const override { return model_->vertex_point(id); }
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override { return model_->edge_geometry(id); }
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId) const override { throw Error(code_, "no such surface"); }
  double area(ModelFaceId id) const override { return model_->area(id); }
  double volume(ModelRegionId id) const override { return model_->volume(id); }

 private:
  ErrorCode code_;
  std::unique_ptr<GeometricModel> model_;
};

}  // namespace tetloom::test_models
