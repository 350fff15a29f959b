#pragma once
// What all ways of meshing a model have in common: sizes, surface and volume, which is left in its parts.
#include <functional>

#include "mesher/volume/volume_parts.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// Called once at most, when the volume is filled: takes the parts, and the mesh, which is the surface. In
/// SharedWork::together, for its ranks.
using TakeVolume = std::function<void(VolumeParts&&, Mesh&, const SharedWork&)>;

/// As make_mesh, where `take` makes of the filled volume what is wanted. Whatever it throws is in the result. `ranks`,
/// where there are some, share the work; they have the same surface, and come to `take` together or not at all.
MeshResult run_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host, const TakeVolume& take,
                    Communicator* ranks = nullptr);

}  // namespace tetloom
