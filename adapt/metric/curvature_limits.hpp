#pragma once
// Sizes on curved surfaces, limited so that the mesh follows them whatever the metric asks for.
#include "adapt/metric/metric_field.hpp"
#include "core/geometry/model.hpp"
#include "core/mesh/mesh.hpp"
#include "threading/task_runner.hpp"

namespace tetloom::adapt {

struct CurvatureLimits {
  double edges_per_turn = 24;  ///< as of the mesher's option: at least so many around a circle; > 0
  double h_min = 0;            ///< sharper curvature asks for no smaller size than this; model length
};

/// Intersects the metrics of the vertices on curved faces and edges of the model with what their curvature asks for:
/// sizes along the principal directions of a face as the mesher has them (mesher/sizing/curvature_size.hpp), inversely
/// proportional to the curvature in that direction, so none along a cylinder's axis; along model edges as the mesher
/// has them too. Sizes along the normal stay. Where a face does not tell its principal directions (facet models), the
/// smaller size holds in the tangent plane.
///
/// The surface is that of `mesh`'s triangles and edges, by their classification; what has none is left alone, as are
/// points where the model has no curvature to tell. Returns how many vertices were changed. Parallel over the faces and
/// edges of the model; the result does not depend on the threads. Errors: InvalidArgument (limits out of range, a
/// metric of another size), InputUnsuitable (the mesh names entities that the model does not have), Cancelled.
std::size_t limit_by_curvature(MetricField& metric, const Mesh& mesh, const GeometricModel& model,
                               const CurvatureLimits& limits, const TaskRunner& runner);

}  // namespace tetloom::adapt
