#pragma once
// The steps of the recovery of one missing edge or triangle.
#include <algorithm>

#include "mesher/tets/obstacles.hpp"
#include "mesher/tets/recovery_cavity.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// Makes one missing edge or triangle of a surface after the other an edge or a face of a mesh.
class Recoverer {
 public:
  Recoverer(LocalMesh& mesh, const EdgeSet& kept, const RecoverOptions& options, RecoveryReport& report,
            const TaskRunner& runner)
      : mesh_(mesh), kept_(kept), options_(options), report_(report), runner_(runner) {}

  /// Whether it is there afterwards; where not, `why` says what is in the way.
  bool recover_edge(std::uint32_t a, std::uint32_t b, Obstacles& why);
  /// Fixes the triangle, too. Pre: its edges are there.
  bool recover_triangle(const TriangleVerts& triangle, Obstacles& why);

  /// Whether the mesh is without the point afterwards and has these triangles instead of the fixed faces at it. They
  /// are not fixed yet. Pre: these faces divide the triangles.
  bool remove_point(std::uint32_t point, std::span<const TriangleVerts> triangles);
  /// Throws Error(Cancelled) once the run is cancelled; also done before each search.
  void check_cancelled() const { runner_.check_cancelled(); }

  /// Searches take no more than this many steps, roughly, until more are granted.
  void grant_steps(std::uint64_t steps) { steps_left_ = steps; }
  std::uint64_t steps_left() const { return steps_left_; }
  void spend_steps(std::uint64_t steps) { steps_left_ -= std::min(steps, steps_left_); }

 private:
  template <class Wanted>
  bool reconnect(const Wanted& wanted, TetList tets);

  LocalMesh& mesh_;
  const EdgeSet& kept_;
  const RecoverOptions& options_;
  RecoveryReport& report_;
  const TaskRunner& runner_;
  std::uint64_t steps_left_ = 0;
};

}  // namespace tetloom::tets
