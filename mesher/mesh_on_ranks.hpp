#pragma once
// From a geometric model to a mesh in one piece, by several ranks.
#include "mesher/mesher.hpp"
#include "threading/communicator.hpp"

namespace tetloom {

/// As make_mesh, by the ranks of `communicator` together. The first rank has the mesh that make_mesh makes, element for
/// element; the meshes of the others are the surface alone, as it was before the volume was filled. All else in the
/// result is the same on all ranks. A collective call, for which all ranks give the same. Errors and thread safety: as
/// make_mesh; one call for each communicator.
MeshResult make_mesh_on_ranks(const GeometricModel& model, const MeshOptions& options, Communicator& communicator,
                              const Host& host = {});

}  // namespace tetloom
