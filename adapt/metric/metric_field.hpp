#pragma once
// A metric at every vertex of a mesh, and what makes it fit for adaptation: bounds, intersection, gradation, a target
// for the number of elements.
//
// Thread safety: functions that take a BlockLoop use its threads, and their results do not depend on it, bit for bit.
// All may throw Error(Cancelled) where the loop does.
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "adapt/metric/tensor.hpp"
#include "adapt/metric/vertex_graph.hpp"
#include "core/base/block_loop.hpp"
#include "core/mesh/mesh.hpp"

namespace tetloom::adapt {

/// One metric per vertex, kept as its logarithm: 48 bytes each.
struct MetricField {
  std::vector<Tensor> logs;  ///< finite

  std::size_t size() const { return logs.size(); }
  Tensor at(std::size_t vert) const { return exp(logs[vert]); }
};

/// The order of a symmetric tensor's six entries in a field.
enum class TensorOrder {
  Medit,  ///< xx xy yy xz yz zz: .sol files
  Vtk     ///< xx yy zz xy yz xz: VTK's symmetric tensors
};

// Metrics from values. `points` are those of the mesh, which errors name. Errors: InvalidArgument where the number of
// values does not fit the points; InputUnsuitable with the vertex as element and its place where a size is not
// positive, a value is NaN or infinite, or a tensor is no metric.

/// The size `sizes[v]` in all directions.
MetricField metric_from_sizes(std::span<const double> sizes, std::span<const Vec3> points,
                              const BlockLoop& loop = serial_loop());
MetricField metric_from_tensors(std::span<const Tensor> tensors, std::span<const Vec3> points,
                                const BlockLoop& loop = serial_loop());
/// From a field with 1 component (sizes), 6 (tensors, in that order) or 9 (matrices row by row, which must be symmetric
/// to 1e-6 of their largest entry). Errors also: InputUnsuitable for other numbers of components.
MetricField metric_from_field(const MeshField& field, TensorOrder order, std::span<const Vec3> points,
                              const BlockLoop& loop = serial_loop());
/// From a callback that returns the metric at a place. It is called from several threads at once.
MetricField metric_from_function(const std::function<Tensor(const Vec3&)>& metric, std::span<const Vec3> points,
                                 const BlockLoop& loop = serial_loop());

/// Six components per vertex in that order, for files.
MeshField field_of_metric(const MetricField& metric, TensorOrder order, const BlockLoop& loop = serial_loop());

/// Limits of the sizes that a metric asks for.
struct MetricBounds {
  double h_min = 0;
  double h_max = HUGE_VAL;
  double max_aspect = HUGE_VAL;  ///< largest size by smallest, at one place; large sizes are reduced to keep it
};
/// Throws Error(InvalidArgument) unless 0 <= h_min <= h_max, h_max > 0 and max_aspect >= 1.
void require_valid(const MetricBounds& bounds);
/// The logarithm of the metric with that logarithm, bounded.
Tensor bounded_log(const Tensor& logarithm, const MetricBounds& bounds);
void apply_bounds(MetricField& metric, const MetricBounds& bounds, const BlockLoop& loop = serial_loop());

/// Makes `metric` the intersection with `other`, vertex by vertex. Pre: the same size.
void intersect(MetricField& metric, const MetricField& other, const BlockLoop& loop = serial_loop());

/// ∫ sqrt(det M), in each tet with the mean of its corners: the number of unit cubes that fill the mesh.
double complexity(const MetricField& metric, const TetView& mesh, const BlockLoop& loop = serial_loop());
/// How many tets a unit mesh of that complexity has, were they regular: 6√2 each. Real ones have 6 to 9.
inline double expected_tets(double complexity) { return 6 * std::sqrt(2.0) * complexity; }

/// Scales all sizes by one factor so that the complexity within `bounds` becomes `target`, to 1e-6 where the bounds
/// allow it, and bounds them. Returns the complexity reached. Pre: target > 0, the mesh has volume.
double scale_to_complexity(MetricField& metric, const TetView& mesh, double target, const MetricBounds& bounds = {},
                           const BlockLoop& loop = serial_loop());

struct GradationResult {
  std::size_t changed = 0;  ///< vertices whose metric was made larger
  std::size_t rounds = 0;
};
/// Limits how fast sizes grow along edges: by a factor `growth` over an edge of unit length. The metric of each vertex
/// is intersected with those of its neighbours as they have grown on the way, until no size changes by more than 1 in
/// 1000. After Alauzet 2010 ("Size gradation control of anisotropic meshes"), the mixed space with the exponent 1/8:
/// nearly the growth that keeps a metric's shape, with some towards isotropy. We depart from the paper in the order:
/// vertices of the smallest elements first, all of about the same size together, each seeing the metrics of the round
/// before; so the result does not depend on who carries out the loop.
/// Errors: InvalidArgument unless growth > 1. Pre: the graph is that of the mesh with those points.
GradationResult limit_gradation(MetricField& metric, std::span<const Vec3> points, const VertexGraph& graph,
                                double growth, const BlockLoop& loop = serial_loop());

struct TurningResult {
  bool turns = false;              ///< too fast; otherwise the metric is as it was
  double asked = 0, followed = 0;  ///< complexities where it does, with no size larger than the mesh
};
/// No mesh follows a metric that turns faster than elements can: an edge that is unit at one end is many times as long
/// by the other. Where a metric does so, its large sizes become smaller, until what is along where a unit step begins
/// is no more than a unit across where it ends. Should that ask for more than 4 times the complexity, all sizes become
/// larger first. Metrics that turn in few places stay as they are, bit by bit, when less than half the complexity would
/// be added, and so do those whose sizes change without a turn, however much. Errors: Cancelled. Pre: sizes fit.
TurningResult limit_turning(MetricField& metric, const TetView& mesh, const BlockLoop& loop = serial_loop());

}  // namespace tetloom::adapt
