#include "core/geometry/stored_model.hpp"

#include <utility>

#include "core/geometry/model_codec.hpp"
#include "tetloom/assert.hpp"

namespace tetloom {

void StoredModel::put_frame(const GeometricModel& model, MessageWriter& skeleton) {
  const ModelTopology& topology = model.topology();
  put_topology(skeleton, topology);
  for (int dim = 0; dim <= 3; ++dim)
    for (std::uint32_t i = 0; i < topology.count(dim); ++i)
      put_attributes(skeleton, model.attributes({static_cast<std::uint8_t>(dim), i}));
  skeleton.put(model.bounding_box());
  skeleton.put(model.metres_per_unit());
  for (std::size_t v = 0; v < topology.vertex_count; ++v) skeleton.put(model.vertex_point(ModelVertexId(v)));
}

StoredModel::StoredModel(std::shared_ptr<const ShapeFile> file, MessageReader& skeleton, std::uint64_t most_bytes)
    : file_(std::move(file)), held_(most_bytes) {
  topology_ = get_topology(skeleton);
  for (int dim = 0; dim <= 3; ++dim)
    for (std::size_t i = 0; i < topology_.count(dim); ++i) attributes_[dim].push_back(get_attributes(skeleton));
  bounding_box_ = skeleton.get<Box3>();
  metres_per_unit_ = skeleton.get<double>();
  for (std::size_t v = 0; v < topology_.vertex_count; ++v) vertices_.push_back(skeleton.get<Vec3>());
}

Vec3 StoredModel::vertex_point(ModelVertexId id) const {
  TETLOOM_ASSERT(id.value < vertices_.size());
  return vertices_[id.value];
}

std::optional<ShapeMemory> StoredModel::shape_memory() const {
  return ShapeMemory{held_.peak_bytes(), file_->total_bytes()};
}

}  // namespace tetloom
