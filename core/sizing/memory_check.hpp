#pragma once
// What a mesh will need, and the refusal of one that cannot fit.
#include <cstdint>

namespace tetloom {

/// How much a mesh will hold and need; tets or triangles alone where the other is not known.
struct MeshEstimate {
  double triangles = 0, tets = 0, bytes = 0;
};

/// Bytes of memory that the machine can give now (Linux: MemAvailable); 0 where that is not known.
std::uint64_t available_memory();

/// Throws Error(OutOfMemory) with the numbers when the mesh needs more than `max_memory` bytes; 0: more than
/// available_memory(), and no check where that is not known.
void check_memory(const MeshEstimate& estimate, std::uint64_t max_memory);

}  // namespace tetloom
