#pragma once
// A CAD model whose shapes lie in a file. Private to core/cad.
#include <filesystem>
#include <memory>
#include <vector>

#include "core/cad/detail/cad_face.hpp"
#include "core/cad/detail/cad_model.hpp"
#include "core/cad/detail/shape_bytes.hpp"
#include "core/geometry/shape_file.hpp"
#include "core/geometry/stored_model.hpp"
#include "tetloom/storage.hpp"

namespace tetloom::cad {

/// Writes the shapes of a model to `file`, and what is known of it without them to `skeleton`. Errors: OutputFailed.
void store_shapes(const CadModel& model, const BlockLoop& loop, ShapeFileWriter& file, MessageWriter& skeleton);

/// The model that store_shapes wrote: it reads the shapes of edges and faces when it is asked for them. All answers are
/// those of the model that was stored, to the last bit.
class StoredCadModel final : public StoredModel {
 public:
  /// Keeps shapes of `most_bytes` at most. Errors: Internal (another skeleton).
  StoredCadModel(std::shared_ptr<const ShapeFile> file, MessageReader& skeleton, std::uint64_t most_bytes);

  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override;
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override;
  FacePlace place(ModelFaceId id) const override;
  std::uint64_t shape_bytes(ModelEntity entity) const override;

 private:
  friend void store_shapes(const CadModel&, const BlockLoop&, ShapeFileWriter&, MessageWriter&);

  /// An edge or a face: the number of its shape in the file, and where that stands.
  struct Placed {
    std::uint64_t shape = 0;
    LocationFactors place;
  };

  std::vector<Placed> edges_, faces_;
  std::vector<std::uint8_t> is_repeated_;  // per face
  std::vector<FacePlace> places_;
};

}  // namespace tetloom::cad
