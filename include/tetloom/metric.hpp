#pragma once
// Metrics for adaptation: tensors, fields of them, and how they are made.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"
#include "tetloom/vec.hpp"

// Symmetric 3x3 tensors: metrics, their logarithms, Hessians.
//
// A metric M is a tensor with positive eigenvalues. The vector e has the length sqrt(eᵀ M e) in it; along an
// eigenvector with the eigenvalue λ the size asked for is 1 / sqrt(λ). So "larger" metrics ask for smaller sizes.
// Interpolation and means are taken of logarithms (Arsigny, Fillard, Pennec & Ayache 2006): the result is a metric, its
// determinant is the geometric mean, and aspect ratios lose no digits in storage, which the entries of M do.
//
// Accuracy: eigenvalues carry an error of some 1e-16 times the largest one, and eigenvectors are orthonormal to
// round-off, whether eigenvalues repeat or not. So the large sizes of a metric given by its entries are known up to
// aspect ratios (of sizes) of about 1e7, further where the eigenvectors lie along the axes; those of a metric given by
// its logarithm always are.
//
// Thread safety: pure functions. Nothing here throws.

namespace tetloom::adapt {

/// The lower triangle, row by row, which is the order of MEDIT files. Default: zero.
struct Tensor {
  double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, zz = 0;

  constexpr Tensor& operator+=(const Tensor& b) {
    xx += b.xx, xy += b.xy, yy += b.yy, xz += b.xz, yz += b.yz, zz += b.zz;
    return *this;
  }
  constexpr Tensor& operator-=(const Tensor& b) {
    xx -= b.xx, xy -= b.xy, yy -= b.yy, xz -= b.xz, yz -= b.yz, zz -= b.zz;
    return *this;
  }
  constexpr Tensor& operator*=(double s) {
    xx *= s, xy *= s, yy *= s, xz *= s, yz *= s, zz *= s;
    return *this;
  }
  friend constexpr bool operator==(const Tensor&, const Tensor&) = default;
};

constexpr Tensor operator+(Tensor a, const Tensor& b) { return a += b; }
constexpr Tensor operator-(Tensor a, const Tensor& b) { return a -= b; }
constexpr Tensor operator*(double s, Tensor a) { return a *= s; }
constexpr Tensor operator*(Tensor a, double s) { return a *= s; }

constexpr Tensor diagonal(double xx, double yy, double zz) { return {xx, 0, yy, 0, 0, zz}; }
/// The metric of size `h` in every direction. Pre: h > 0.
constexpr Tensor isotropic(double h) { return diagonal(1 / (h * h), 1 / (h * h), 1 / (h * h)); }
/// s v vᵀ.
constexpr Tensor outer(const Vec3& v, double s = 1) {
  return {s * v.x * v.x, s * v.x * v.y, s * v.y * v.y, s * v.x * v.z, s * v.y * v.z, s * v.z * v.z};
}

/// M v.
constexpr Vec3 operator*(const Tensor& m, const Vec3& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
/// eᵀ M e: the squared length of e in the metric M.
constexpr double dot(const Tensor& m, const Vec3& e) {
  return m.xx * (e.x * e.x) + m.yy * (e.y * e.y) + m.zz * (e.z * e.z) +
         2 * (m.xy * (e.x * e.y) + m.xz * (e.x * e.z) + m.yz * (e.y * e.z));
}
/// aᵀ M b.
constexpr double dot(const Vec3& a, const Tensor& m, const Vec3& b) { return dot(a, m * b); }
constexpr double trace(const Tensor& m) { return m.xx + m.yy + m.zz; }
constexpr double det(const Tensor& m) {
  return m.xx * (m.yy * m.zz - m.yz * m.yz) - m.xy * (m.xy * m.zz - m.yz * m.xz) + m.xz * (m.xy * m.yz - m.yy * m.xz);
}
inline bool is_finite(const Tensor& m) {
  return std::isfinite(m.xx) && std::isfinite(m.xy) && std::isfinite(m.yy) && std::isfinite(m.xz) &&
         std::isfinite(m.yz) && std::isfinite(m.zz);
}

/// The logarithmic mean (a - b) / log(a / b) of two lengths: the length of an edge whose density changes geometrically
/// from one end to the other. Symmetric, and between a and b. Pre: a, b >= 0.
inline double logarithmic_mean(double a, double b) {
  const double sum = a + b;
  if (!(sum > 0)) return sum;
  const double r = (a - b) / sum;
  const double r2 = r * r;
  // log(a / b) = 2 atanh(r); the series of r / atanh(r) is exact to 1e-12 here.
  if (r2 < 0.0025) return 0.5 * sum * (1 - r2 * (1.0 / 3 + r2 * (4.0 / 45 + r2 * (44.0 / 945))));
  const double small = a < b ? a : b, large = a < b ? b : a;
  return small > 0 ? (large - small) / std::log(large / small) : 0;
}

/// The length of the edge e between two vertices with the metrics `ma` and `mb` (Alauzet 2010, geometric variation of
/// the size along the edge).
inline double edge_length(const Tensor& ma, const Tensor& mb, const Vec3& e) {
  return logarithmic_mean(std::sqrt(dot(ma, e)), std::sqrt(dot(mb, e)));
}

/// Where on an edge the length from its first end is `share` of the whole, by the lengths that its ends give it: sizes
/// change geometrically on the way. Not within a tenth of an end.
inline double place_on_edge(double la, double lb, double share) {
  const double r = lb / la;
  if (!(std::abs(r - 1) > 1e-3)) return share;
  const double s = std::log1p(share * (r - 1)) / std::log(r);
  return std::isfinite(s) ? std::clamp(s, 0.1, 0.9) : share;
}

/// Eigenvalues in ascending order, and a right-handed orthonormal basis of eigenvectors.
struct EigenSystem {
  std::array<double, 3> values{};
  std::array<Vec3, 3> vectors{};
};

/// By cyclic Jacobi rotations (Golub & Van Loan, 8.5). A tensor with NaN or infinite entries gives anything.
EigenSystem eigen(const Tensor& m);

/// Σ value vector vectorᵀ.
constexpr Tensor compose(const EigenSystem& e) {
  return outer(e.vectors[0], e.values[0]) + outer(e.vectors[1], e.values[1]) + outer(e.vectors[2], e.values[2]);
}

/// The tensor with the same eigenvectors and f of the eigenvalues.
template <class Function>
Tensor map_eigenvalues(const Tensor& m, const Function& f) {
  EigenSystem e = eigen(m);
  for (double& value : e.values) value = f(value);
  return compose(e);
}

/// Finite, and every eigenvalue positive.
bool is_positive_definite(const Tensor& m);

/// The logarithm of a metric. Pre: is_positive_definite(m).
Tensor log(const Tensor& m);
/// The metric with that logarithm.
Tensor exp(const Tensor& logarithm);
/// log(isotropic(h)). Pre: h > 0.
inline Tensor log_isotropic(double h) {
  const double l = -2 * std::log(h);
  return diagonal(l, l, l);
}

/// The metric that asks for the smaller of two sizes in each direction of the basis in which both are diagonal
/// (simultaneous reduction, Alauzet & Frey 2003). Not smaller than either: dot(result, e) >= max(dot(a, e), dot(b, e))
/// up to round-off. Returns `a` or `b` itself where it is not smaller than the other. Symmetric up to round-off, but
/// not associative. Pre: both positive definite.
Tensor intersection(const Tensor& a, const Tensor& b);

// Which vertices of a mesh of tetrahedra share an edge.

using TetVerts = std::array<std::uint32_t, 4>;

/// The points of a mesh and its tetrahedra. Non-owning.
struct TetView {
  std::span<const Vec3> points;
  std::span<const TetVerts> tets;
};

inline TetView tets_of(const Mesh& mesh) { return {mesh.points, mesh.tet_to_vert}; }

/// Neighbours of vertices across edges, ascending.
class VertexGraph {
 public:
  /// Pre: indices in range. Linear; 64 bytes per tet while it is built, about 60 per vertex afterwards.
  explicit VertexGraph(const TetView& mesh, const BlockLoop& loop = serial_loop());
  /// Of lists: the neighbours of v are `neighbors` from `begins[v]` on up to `begins[v + 1]`, ascending.
  VertexGraph(std::vector<std::size_t> begins, std::vector<std::uint32_t> neighbors)
      : begins_(std::move(begins)), neighbors_(std::move(neighbors)) {}

  std::size_t size() const { return begins_.size() - 1; }
  std::span<const std::uint32_t> neighbors(std::size_t vert) const {
    return {neighbors_.data() + begins_[vert], begins_[vert + 1] - begins_[vert]};
  }

 private:
  std::vector<std::size_t> begins_;  ///< one more than vertices
  std::vector<std::uint32_t> neighbors_;
};

// A metric at every vertex of a mesh, and what makes it fit for adaptation: bounds, intersection, gradation, a target
// for the number of elements.
//
// Thread safety: functions that take a BlockLoop use its threads, and their results do not depend on it, bit for bit.
// All may throw Error(Cancelled) where the loop does.

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

/// What limiting the gradation has done.
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

/// What limiting the turning has done.
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

// A metric from the second derivatives of a solution, so that linear interpolation of it has an error as small as the
// number of elements allows.
//
// Thread safety: functions use the threads of the loop; their results do not depend on it, bit for bit.

/// Second derivatives of a field at every vertex: those of the quadratic polynomial that fits the values at the
/// vertices within two edges best, in weighted least squares. Exact for quadratic fields, at the boundary as well, up
/// to round-off; first order elsewhere. Neighbourhoods are scaled to be as long as wide before the fit, so that
/// stretched meshes are no worse. Where two rings do not determine the polynomial, a third one is used; what is not
/// determined then (the second derivative through a plate of one layer) is as small as possible. Vertices without tets
/// have zero. `graph` is that of the mesh. Errors: InvalidArgument where the number of values does not fit;
/// InputUnsuitable with vertex and place for values that are not finite. About 10 µs per vertex.
std::vector<Tensor> recover_hessian(std::span<const double> values, const TetView& mesh, const VertexGraph& graph,
                                    const BlockLoop& loop = serial_loop());

/// How a metric is made of a field.
struct HessianOptions {
  double complexity = 0;  ///< of the metric, > 0; expected_tets(complexity) tells the tets
  double norm = 2;        ///< the error is small in the Lᵖ norm with this p, >= 1, may be infinite: 1 and 2 resolve
                          ///< weak features beside strong ones
  MetricBounds bounds;    ///< h_max is reduced to the diagonal of the mesh
  double gradation = 0;   ///< see limit_gradation; 0 for none
};

/// A metric that was made of a field.
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

/// The metric of a solution that lies in a mesh: a field of one component on its points.
struct SolutionMetric {
  std::string field;
  HessianOptions options;
};

// Sizes on curved surfaces, limited so that the mesh follows them whatever the metric asks for.

/// What curved faces and edges ask of a metric.
struct CurvatureLimits {
  double edges_per_turn = 24;  ///< as of the mesher's option: at least so many around a circle; > 0
  double h_min = 0;            ///< sharper curvature asks for no smaller size than this; model length
};

/// Intersects the metrics of the vertices on curved faces and edges of the model with what their curvature asks for:
/// sizes along the principal directions of a face as the mesher has them (core/sizing/curvature_size.hpp), inversely
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
