#include "core/geometry/stored_model.hpp"

#include <utility>

#include "core/base/codec.hpp"
#include "core/base/failure.hpp"
#include "core/geometry/model_codec.hpp"
#include "tetloom/assert.hpp"

namespace tetloom {
namespace {

template <class Measured>
void put_measures(MessageWriter& writer, std::size_t count, const BlockLoop& loop, const Measured& measure) {
  std::vector<double> values(count);
  std::vector<std::optional<Diagnostic>> failures(count);
  loop.for_blocks(count, 1,
                  [&](std::size_t i, std::size_t) { failures[i] = failure_of([&] { values[i] = measure(i); }); });
  for (std::size_t i = 0; i < count; ++i) {
    writer.put(values[i]);
    writer.put(failures[i].has_value());
    if (failures[i]) put_diagnostic(writer, *failures[i]);
  }
}

}  // namespace

void StoredModel::put_frame(const GeometricModel& model, const BlockLoop& loop, MessageWriter& skeleton) {
  const ModelTopology& topology = model.topology();
  put_topology(skeleton, topology);
  for (int dim = 0; dim <= 3; ++dim)
    for (std::uint32_t i = 0; i < topology.count(dim); ++i)
      put_attributes(skeleton, model.attributes({static_cast<std::uint8_t>(dim), i}));
  skeleton.put(model.bounding_box());
  skeleton.put(model.metres_per_unit());
  for (std::size_t v = 0; v < topology.vertex_count; ++v) skeleton.put(model.vertex_point(ModelVertexId(v)));
  put_measures(skeleton, topology.face_count(), loop, [&](std::size_t f) { return model.area(ModelFaceId(f)); });
  put_measures(skeleton, topology.region_count(), loop, [&](std::size_t r) { return model.volume(ModelRegionId(r)); });
}

StoredModel::StoredModel(std::shared_ptr<const ShapeFile> file, MessageReader& skeleton, std::uint64_t most_bytes)
    : file_(std::move(file)), held_(most_bytes) {
  topology_ = get_topology(skeleton);
  for (int dim = 0; dim <= 3; ++dim)
    for (std::size_t i = 0; i < topology_.count(dim); ++i) attributes_[dim].push_back(get_attributes(skeleton));
  bounding_box_ = skeleton.get<Box3>();
  metres_per_unit_ = skeleton.get<double>();
  for (std::size_t v = 0; v < topology_.vertex_count; ++v) vertices_.push_back(skeleton.get<Vec3>());
  areas_ = get_measures(skeleton, topology_.face_count());
  volumes_ = get_measures(skeleton, topology_.region_count());
}

std::vector<StoredModel::Measure> StoredModel::get_measures(MessageReader& skeleton, std::size_t count) {
  std::vector<Measure> measures(count);
  for (Measure& measure : measures) {
    measure.value = skeleton.get<double>();
    if (skeleton.get<bool>()) measure.failure = get_diagnostic(skeleton);
  }
  return measures;
}

double StoredModel::area(ModelFaceId id) const {
  TETLOOM_ASSERT(id.value < areas_.size());
  return areas_[id.value].get();
}

double StoredModel::volume(ModelRegionId id) const {
  TETLOOM_ASSERT(id.value < volumes_.size());
  return volumes_[id.value].get();
}

Vec3 StoredModel::vertex_point(ModelVertexId id) const {
  TETLOOM_ASSERT(id.value < vertices_.size());
  return vertices_[id.value];
}

std::optional<ShapeMemory> StoredModel::shape_memory() const {
  return ShapeMemory{held_.peak_bytes(), file_->total_bytes()};
}

}  // namespace tetloom
