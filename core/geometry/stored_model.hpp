#pragma once
// A model whose shapes lie in a file: what all such models have in common.
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/held_shapes.hpp"
#include "core/geometry/shape_file.hpp"
#include "tetloom/model.hpp"
#include "tetloom/storage.hpp"

namespace tetloom {

/// For one process of several: topology, names, vertices and measures are in memory, and those shapes that were used
/// last.
class StoredModel : public GeometricModel {
 public:
  /// What a model is without its shapes, for the constructor. Measures are taken on the threads of `loop`.
  static void put_frame(const GeometricModel& model, const BlockLoop& loop, MessageWriter& skeleton);

  Vec3 vertex_point(ModelVertexId id) const final;
  double area(ModelFaceId id) const final;
  double volume(ModelRegionId id) const final;
  std::optional<ShapeMemory> shape_memory() const final;

 protected:
  /// Keeps shapes of `most_bytes` at most. Errors: Internal (another skeleton).
  StoredModel(std::shared_ptr<const ShapeFile> file, MessageReader& skeleton, std::uint64_t most_bytes);

  const ShapeFile& file() const { return *file_; }
  HeldShapes& held() const { return held_; }

 private:
  /// A value, or why there is none.
  struct Measure {
    double value = 0;
    std::optional<Diagnostic> failure;

    double get() const { return failure ? throw Error(*failure) : value; }
  };
  static std::vector<Measure> get_measures(MessageReader& skeleton, std::size_t count);

  std::shared_ptr<const ShapeFile> file_;
  mutable HeldShapes held_;
  std::vector<Vec3> vertices_;
  std::vector<Measure> areas_, volumes_;
};

}  // namespace tetloom
