#pragma once
// The parts of a volume as parts of a mesh, with everything that is known of the surface that it was filled from.
#include "mesher/layers/layered_parts.hpp"
#include "mesher/volume/volume_parts.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/partition.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// A mesh of `part_count` parts, of which `parts`, as of VolumeParts, are those of this rank, linked: vertices,
/// triangles and pieces of model edges are classified as `surface` says, which holds the points, triangles and edges
/// that the volume was filled from. Each part gets the triangles and edges that its tets have, and what the surface
/// knows of the model entities that it lies on. With `layers`, which may be null, the stacks below the tops in
/// `surface` are added, each to the part that has its top. `parts` is emptied on the way. A collective call. Errors, on
/// all ranks alike: Cancelled, OutOfMemory; InputUnsuitable when a part is too large.
PartitionedMesh classify_parts(const Mesh& surface, std::vector<PartMesh>&& parts, std::size_t part_count,
                               const layers::PartLayers* layers, const SharedWork& work);

}  // namespace tetloom
