#pragma once
// The surface of a mesh while its volume is filled.
#include <span>
#include <vector>

#include "core/base/fixed_array.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"

namespace tetloom {

/// What fill_volume takes of a mesh. Where `keep` keeps the arrays, the mesh is without them until this ends, and
/// has them again then: without any elements where there is no memory for them.
class SurfaceInput {
 public:
  /// Where `keep` throws, the mesh is as it was.
  SurfaceInput(Mesh& mesh, const ModelTopology& topology, const KeepBytes& keep);
  ~SurfaceInput();
  SurfaceInput(const SurfaceInput&) = delete;
  SurfaceInput& operator=(const SurfaceInput&) = delete;

  /// Refers to this and to the arguments.
  VolumeInput input(const GeometricModel& model, const SizeField& sizes) const;

 private:
  /// An array that lies elsewhere for a while.
  template <class T>
  struct Lent {
    Lent(std::vector<T>& from, const KeepBytes& keep);
    void leave_home();
    void give_back();

    std::vector<T>& home;
    std::shared_ptr<const std::byte> kept;  // null: nobody keeps it
    std::span<const T> values;
  };

  Mesh& mesh_;
  FixedArray<FaceSides> sides_;
  Lent<Vec3> points_;
  Lent<ModelEntity> point_to_entity_;
  Lent<std::array<std::uint32_t, 2>> edge_to_vert_;
  Lent<std::array<std::uint32_t, 3>> tri_to_vert_;
  Lent<std::uint32_t> tri_to_entity_;
};

}  // namespace tetloom
