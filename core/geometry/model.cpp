#include "tetloom/model.hpp"

#include "tetloom/assert.hpp"

namespace tetloom {

std::size_t ModelTopology::count(int dim) const {
  switch (dim) {
    case 0: return vertex_count;
    case 1: return edge_count();
    case 2: return face_count();
    case 3: return region_count();
    default: return 0;
  }
}

const EntityAttributes& GeometricModel::attributes(ModelEntity entity) const {
  TETLOOM_ASSERT(entity.dim <= 3 && entity.index < attributes_[entity.dim].size());
  return attributes_[entity.dim][entity.index];
}

NamedEntity GeometricModel::named(ModelEntity entity) const { return {entity, attributes(entity).name}; }

}  // namespace tetloom
