#pragma once
// A metric from the second derivatives of a solution, so that linear interpolation of it has an error as small as the
// number of elements allows.
//
// Thread safety: functions use the threads of the loop; their results do not depend on it, bit for bit.
#include <cmath>
#include <span>
#include <vector>

#include "adapt/metric/metric_field.hpp"
#include "adapt/metric/tensor.hpp"
#include "adapt/metric/vertex_graph.hpp"

namespace tetloom::adapt {

/// Second derivatives of a field at every vertex: those of the quadratic polynomial that fits the values at the
/// vertices within two edges best, in weighted least squares. Exact for quadratic fields, at the boundary as well, up
/// to round-off; first order elsewhere. Neighbourhoods are scaled to be as long as wide before the fit, so that
/// stretched meshes are no worse. Where two rings do not determine the polynomial, a third one is used; what is not
/// determined then (the second derivative through a plate of one layer) is as small as possible. Vertices without tets
/// have zero. `graph` is that of the mesh. Errors: InvalidArgument where the number of values does not fit;
/// InputUnsuitable with vertex and place for values that are not finite. About 10 µs per vertex.
std::vector<Tensor> recover_hessian(std::span<const double> values, const TetView& mesh, const VertexGraph& graph,
                                    const BlockLoop& loop = serial_loop());

struct HessianOptions {
  double complexity = 0;  ///< of the metric, > 0; expected_tets(complexity) tells the tets
  double norm = 2;        ///< the error is small in the Lᵖ norm with this p, >= 1, may be infinite: 1 and 2 resolve
                          ///< weak features beside strong ones
  MetricBounds bounds;    ///< h_max is reduced to the diagonal of the mesh
  double gradation = 0;   ///< see limit_gradation; 0 for none
};

struct HessianMetric {
  MetricField metric;
  double complexity = 0;  ///< reached; off from what was asked for where bounds do not allow it
};

/// The metric of least interpolation error in that norm among those of that complexity (Loseille & Alauzet 2011): the
/// absolute Hessian times det^(-1 / (2p + 3)), scaled; then bounded, graded, kept from turning too fast, and scaled
/// again until the complexity is within 1 % of what was asked for. Errors: InvalidArgument (options out of range,
/// another number of Hessians than points); InputUnsuitable where no second derivative is larger than `flat`,
/// everywhere: there is nothing to adapt to.
HessianMetric metric_from_hessian(std::span<const Tensor> hessians, double flat, const TetView& mesh,
                                  const VertexGraph& graph, const HessianOptions& options,
                                  const BlockLoop& loop = serial_loop());

/// Both steps for a scalar field. Second derivatives that change the field by less than 1e-9 of its range across the
/// mesh count as none.
HessianMetric metric_from_solution(std::span<const double> values, const TetView& mesh, const HessianOptions& options,
                                   const BlockLoop& loop = serial_loop());

}  // namespace tetloom::adapt
