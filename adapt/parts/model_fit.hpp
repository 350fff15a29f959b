#pragma once
// Whether a mesh and a model belong together.
#include <cstdint>
#include <optional>
#include <span>

#include "adapt/parts/whole_mesh.hpp"
#include "tetloom/error.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// Vertices that lie beside what they are classified on, as where a small feature of the model was eliminated when the
/// mesh was made: up to the longest edge of the surface there.
struct VerticesBesideModel {
  std::int64_t vertices = 0;  ///< on the model's vertices, edges and faces
  std::int64_t count = 0;     ///< of these, those beside it
  std::optional<Diagnostic> first;
};

/// Throws Error(InputUnsuitable), with the entity and the place, unless `mesh`, and `whole`, which was made from it,
/// name entities that `model` has, every edge in which its faces meet is a piece of a model edge, and every vertex
/// lies on the model vertex, edge or face that it is classified on: within the entity's tolerance or a millionth of
/// the model's size, or within a tenth of the shortest edge of the surface there, for vertices that could not be
/// snapped to the surface before. Those farther away are thrown for or returned. Also Cancelled. Parallel over the
/// entities; the error does not depend on the threads. `numbers`: what vertices are called in errors; none: as they
/// stand.
VerticesBesideModel require_model_fits(const WholeMesh& whole, const Mesh& mesh, const GeometricModel& model,
                                       const TaskRunner& runner, std::span<const Number> numbers = {});

/// Throws for the first vertex beside the model if more than one in eight are: then it is another model.
void require_few(const VerticesBesideModel& beside);

}  // namespace tetloom::adapt
