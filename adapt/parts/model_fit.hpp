#pragma once
// Whether a mesh and a model belong together.
#include <cstdint>
#include <span>

#include "adapt/parts/whole_mesh.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// Throws Error(InputUnsuitable), with the entity and the place, unless `mesh`, and `whole`, which was made from it,
/// name entities that `model` has, every edge in which its faces meet is a piece of a model edge, and every vertex
/// lies on the model vertex, edge or face that it is classified on: within the entity's tolerance or a millionth of
/// the model's size, or within a tenth of the shortest edge of the surface there, for vertices that could not be
/// snapped to the surface before. Also Cancelled. Parallel over the entities; the error does not depend on the threads.
/// `numbers`: what vertices are called in errors; none: as they stand.
void require_model_fits(const WholeMesh& whole, const Mesh& mesh, const GeometricModel& model, const TaskRunner& runner,
                        std::span<const std::uint32_t> numbers = {});

}  // namespace tetloom::adapt
