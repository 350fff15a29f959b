#include "core/discrete/stored_facet_model.hpp"

#include <utility>

#include "core/discrete/discrete_edge.hpp"
#include "core/discrete/discrete_face.hpp"
#include "core/discrete/facet_model.hpp"
#include "tetloom/assert.hpp"

namespace tetloom::detail {

bool store_facets(const GeometricModel& model, const BlockLoop& loop, ShapeFileWriter& file, MessageWriter& skeleton) {
  const auto* facets = dynamic_cast<const FacetModel*>(&model);
  if (!facets) return false;
  const DiscreteParts& parts = facets->parts();
  const ModelTopology& topology = model.topology();
  for (std::uint32_t edge = 0; edge < topology.edge_count(); ++edge) {
    const Polyline& line = parts.polyline(edge);
    MessageWriter shape;
    shape.put_array<Vec3>(line.points);
    shape.put_array<double>(line.lengths);
    shape.put(line.closed);
    file.add(shape.take());
  }
  for (std::uint32_t face = 0; face < topology.face_count(); ++face) {
    MessageWriter shape;
    parts.put_face(shape, face);
    file.add(shape.take());
  }
  StoredModel::put_frame(model, loop, skeleton);
  skeleton.put_array<double>(parts.edge_lengths());
  return true;
}

StoredFacetModel::StoredFacetModel(std::shared_ptr<const ShapeFile> file, MessageReader& skeleton,
                                   std::uint64_t most_bytes)
    : StoredModel(std::move(file), skeleton, most_bytes) {
  edge_lengths_ = std::make_shared<const std::vector<double>>(skeleton.get_array<double>());
}

std::unique_ptr<EdgeGeometry> StoredFacetModel::edge_geometry(ModelEdgeId id) const {
  TETLOOM_ASSERT(id.value < topology_.edge_count());
  return std::make_unique<DiscreteEdge>(held().get<Polyline>(id.value, [&] {
    const Bytes bytes = file().read(id.value);
    MessageReader shape(bytes);
    auto line = std::make_shared<Polyline>();
    line->points = shape.get_array<Vec3>();
    line->lengths = shape.get_array<double>();
    line->closed = shape.get<bool>();
    return HeldShapes::Shape{std::move(line), bytes.size()};
  }));
}

std::unique_ptr<FaceGeometry> StoredFacetModel::face_geometry(ModelFaceId id) const {
  TETLOOM_ASSERT(id.value < topology_.face_count());
  const std::size_t number = topology_.edge_count() + id.value;
  auto facets = held().get<FaceFacets>(number, [&] {
    const Bytes bytes = file().read(number);
    MessageReader shape(bytes);
    auto read = std::make_shared<FaceFacets>();
    get_facets(shape, *read);
    return HeldShapes::Shape{std::move(read), bytes.size()};
  });
  return std::make_unique<DiscreteFace>(std::move(facets), edge_lengths_);
}

std::uint64_t StoredFacetModel::shape_bytes(ModelEntity entity) const {
  if (entity.dim != 1 && entity.dim != 2) return 0;
  TETLOOM_ASSERT(entity.index < topology_.count(entity.dim));
  return file().bytes_of(entity.dim == 1 ? entity.index : topology_.edge_count() + entity.index);
}

}  // namespace tetloom::detail
