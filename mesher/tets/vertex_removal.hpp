#pragma once
// Removes a vertex by merging it into a neighbour: its star is filled by the tets from that neighbour to the faces of
// the star's boundary.
#include <cstddef>
#include <cstdint>

#include "core/tets/vertex_star.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// Holds the room that one removal needs.
class VertexRemover {
 public:
  explicit VertexRemover(WorkingMesh& mesh) : mesh_(mesh) {}

  /// Merges one of the vertices of `tet` that can move into that neighbour which makes the star's minimum largest, if
  /// that is larger than it was. New tets are positive in exact arithmetic. False, and nothing changes, when there is
  /// no such vertex.
  bool remove_vertex_of(std::uint32_t tet);

 private:
  void try_star();
  double least_with(std::uint32_t target, double goal) const;
  void apply();

  WorkingMesh& mesh_;
  VertexStar star_, best_star_;
  std::uint32_t best_target_ = kNone;
  double best_ = 0;
};

/// VertexRemover::remove_vertex_of for the tets of cubed quality below `limit`, in order of ids. Returns the number of
/// vertices removed.
std::size_t remove_vertices(WorkingMesh& mesh, double limit, const TaskRunner& runner);

}  // namespace tetloom::tets
