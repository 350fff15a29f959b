#pragma once
// Moves interior vertices so that the worst tetrahedra around them become better.
//
// Each step minimises, over the position of one vertex, the sum of 1/q^3 of the tetrahedra at it, where q is the mean
// ratio 12 (3V)^(2/3) / (sum of squared edges): a convex function (as used by Freitag & Knupp 2002 with other
// exponents) whose gradient and Hessian are closed forms, so one damped Newton step does. Departure: only vertices at
// tetrahedra worse than a threshold move, which is where the gain is.
#include <cstddef>

#include "mesher/volume/region_coloring.hpp"
#include "threading/task_runner.hpp"

namespace tetloom::volume {

struct SmoothingOptions {
  std::size_t fixed_points = 0;  ///< points before this one stay where they are
  double threshold = 0.7;        ///< vertices at tetrahedra of lower quality move
  int sweeps = 3;
};

/// Pre: all tetrahedra have positive volume; they have afterwards, in exact arithmetic, and no move raises the sum it
/// minimises. Vertices are taken in order of their ids, one after the other: the result depends on the filling alone.
/// Errors: Cancelled.
void smooth_interior(Filling& filling, const SmoothingOptions& options, const TaskRunner& runner);

}  // namespace tetloom::volume
