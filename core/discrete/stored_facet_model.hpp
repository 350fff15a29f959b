#pragma once
// A model of facets whose faces and edges lie in a file. Private to core.
#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/shape_file.hpp"
#include "core/geometry/stored_model.hpp"
#include "tetloom/storage.hpp"

namespace tetloom::detail {

/// Writes the edges and faces of a model of facets to `file`, and what is known of it without them to `skeleton`.
/// False, and nothing written, for other models. Errors: OutputFailed.
bool store_facets(const GeometricModel& model, const BlockLoop& loop, ShapeFileWriter& file, MessageWriter& skeleton);

/// The model that store_facets wrote: it reads polylines and facets of faces when it is asked for them. All answers are
/// those of the model that was stored, to the last bit. The tree of a face is made anew with it, in O(n log n).
class StoredFacetModel final : public StoredModel {
 public:
  /// Keeps shapes of `most_bytes` at most. Errors: Internal (another skeleton).
  StoredFacetModel(std::shared_ptr<const ShapeFile> file, MessageReader& skeleton, std::uint64_t most_bytes);

  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override;
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override;
  std::uint64_t shape_bytes(ModelEntity entity) const override;

 private:
  std::shared_ptr<const std::vector<double>> edge_lengths_;
};

}  // namespace tetloom::detail
