#pragma once
// Many faces at once, on the threads of all ranks.
#include <cstddef>
#include <span>
#include <vector>

#include "mesher/surface/face_mesher.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// Meshes the faces numbered by `pending` into `faces`: whole ones and pieces of large ones side by side, largest
/// first, each on one rank; then the large ones are put together. All ranks have all of them in the end. Faces that
/// fail say so in their verdict. Pre: all ranks give the same. Errors: Cancelled, OutOfMemory.
void mesh_faces(const GeometricModel& model, std::span<const std::size_t> pending, const FaceSurroundings& surroundings,
                const SharedWork& work, std::vector<FaceMesh>& faces);

}  // namespace tetloom
