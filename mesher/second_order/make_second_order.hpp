#pragma once
// From a mesh of straight elements to one of second order.
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::second_order {

/// Gives `mesh` mid nodes, on the curves and faces of the model where that leaves every tet valid: its Jacobian is
/// proven to be at least `min_scaled_jacobian` times that of the straight tet. The result does not depend on the number
/// of threads. Pre: require_consistent(mesh), of first order, tets positive. Errors: what the runner throws.
SecondOrderFigures make_second_order(const GeometricModel& model, double min_scaled_jacobian, Mesh& mesh,
                                     const TaskRunner& runner);

}  // namespace tetloom::second_order
