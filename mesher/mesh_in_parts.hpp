#pragma once
// From a geometric model to a mesh in parts, which is nowhere put together.
#include <optional>

#include "mesher/mesher.hpp"
#include "threading/partitioned_mesh.hpp"

namespace tetloom {

struct MeshInPartsResult {
  MeshResult run;  ///< as of make_mesh, but its mesh is the surface alone, as it was before the volume was filled
  std::optional<PartitionedMesh> mesh;  ///< when the run's status is Ok
  double partition_seconds = 0;         ///< of dealing the mesh to parts
};

/// The mesh that make_mesh makes, in parts: `options.parts` of them, or, where that is 0, those in which volumes were
/// filled, which are complexes (regions connected through faces) and the parts of large ones. Global ids of vertices
/// are their numbers in make_mesh's mesh, but for sheets and wires, which have no part in it.
///
/// Errors: InvalidArgument is thrown, for options out of range and for surface_only. In the result: what make_mesh
/// says, and InputUnsuitable, before any work is done, for a model without regions and for one with faces or edges that
/// bound none. Thread safety: one call for each communicator.
MeshInPartsResult make_mesh_in_parts(const GeometricModel& model, const MeshOptions& options,
                                     Communicator& communicator, const Host& host = {});

}  // namespace tetloom
