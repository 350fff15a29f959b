#pragma once
// Moves vertices so that the tets around them become better: one damped Newton step each, of those at poor tets.
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/tets/star_tet.hpp"
#include "core/tets/vertex_star.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

enum class MoveVerdict { Moved, OnSurface, TooLarge, NoGain };

/// Moves vertices by such steps (core/tets/newton_step.hpp), those of nearly flat tets to the deepest place of their
/// star where that is better; holds the room that one move needs. `floor`: as for the step.
class VertexMover {
 public:
  VertexMover(WorkingMesh& mesh, double floor) : mesh_(mesh), floor_(floor) {}

  /// Moves the vertex at `corner` of `tet`.
  MoveVerdict move(std::uint32_t tet, std::uint32_t corner);

 private:
  WorkingMesh& mesh_;
  double floor_;
  VertexStar star_;
  std::array<StarTet, WorkingMesh::kMostTets> tets_;
};

/// Moves every vertex of the tets of cubed quality below `limit` once, in order of the tets' ids. Returns
/// the number of moves.
std::size_t move_vertices(WorkingMesh& mesh, double limit, const TaskRunner& runner);

}  // namespace tetloom::tets
