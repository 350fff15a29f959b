#pragma once
// What all ways of meshing a model have in common: sizes, surface and volume, which is left in its parts.
#include <functional>

#include "mesher/layers/grow_layers.hpp"
#include "mesher/volume/volume_parts.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// What becomes of a filled volume. One of both is called, once at most, in SharedWork::together for its ranks.
struct VolumeUse {
  /// Takes the parts, and the mesh, which is the surface that was filled.
  std::function<void(VolumeParts&&, Mesh&, const SharedWork&)> take;
  /// Takes the parts, which lie above layers, and the mesh on which these were grown. Returns the seconds that were
  /// spent on layers.
  std::function<double(VolumeParts&&, const layers::LayerGrowth&, Mesh&, const SharedWork&)> take_above_layers;
};

/// As make_mesh, where `use` makes of the filled volume what is wanted. Whatever it throws is in the result. `ranks`,
/// where there are some, share the work; they have the same surface, and come to `use` together or not at all.
MeshResult run_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host, const VolumeUse& use,
                    Communicator* ranks = nullptr);

}  // namespace tetloom
