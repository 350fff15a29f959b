#pragma once
// Layers that memory cannot hold are refused before they are grown.
#include <cstdint>

#include "tetloom/layers.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"

namespace tetloom::layers {

/// Throws Error(OutOfMemory), with the face that has most of the cells and a point on it, when the layers asked for
/// need more than `max_memory` bytes; 0: more than the machine has free. Counted are layers that are no higher than
/// wide, whatever else may stop them, and the mesh that they become.
void check_layer_memory(const GeometricModel& model, const Mesh& mesh, const LayerOptions& options,
                        std::uint64_t max_memory);

}  // namespace tetloom::layers
