#pragma once
// A model whose shapes lie in a file: what all such models have in common.
#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/held_shapes.hpp"
#include "core/geometry/shape_file.hpp"
#include "tetloom/model.hpp"
#include "tetloom/storage.hpp"

namespace tetloom {

/// For one process of several: topology, names and vertices are in memory, and those shapes that were used last.
class StoredModel : public GeometricModel {
 public:
  /// What a model is without its shapes, for the constructor.
  static void put_frame(const GeometricModel& model, MessageWriter& skeleton);

  Vec3 vertex_point(ModelVertexId id) const final;
  std::optional<ShapeMemory> shape_memory() const final;

 protected:
  /// Keeps shapes of `most_bytes` at most. Errors: Internal (another skeleton).
  StoredModel(std::shared_ptr<const ShapeFile> file, MessageReader& skeleton, std::uint64_t most_bytes);

  const ShapeFile& file() const { return *file_; }
  HeldShapes& held() const { return held_; }

 private:
  std::shared_ptr<const ShapeFile> file_;
  mutable HeldShapes held_;
  std::vector<Vec3> vertices_;
};

}  // namespace tetloom
