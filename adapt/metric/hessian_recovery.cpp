// Second derivatives by weighted least squares.
#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include "adapt/metric/own_hessian.hpp"
#include "core/base/grain.hpp"
#include "core/base/lists.hpp"
#include "tetloom/error.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {
namespace {

constexpr std::size_t kUnknowns = 10;
/// A column of which less than this is left beside those before it is not determined.
constexpr double kDeterminedFit = 1e-2;
/// How much small second derivatives count, where the values alone do not determine them.
constexpr double kPenalty = 1e-2;
constexpr std::size_t kPenaltyRows = 6;

/// The vertices within a number of edges of one, itself among them.
class Neighborhood {
 public:
  explicit Neighborhood(const VertexGraph& graph) : graph_(graph) {}

  const std::vector<std::uint32_t>& find(std::uint32_t vert, int rings) {
    found_.assign(1, vert);
    for (int ring = 0; ring < rings; ++ring) {
      next_ = found_;
      for (const std::uint32_t v : found_) {
        const auto neighbors = graph_.neighbors(v);
        next_.insert(next_.end(), neighbors.begin(), neighbors.end());
      }
      sort_unique(next_);
      found_.swap(next_);
    }
    return found_;
  }

 private:
  const VertexGraph& graph_;
  std::vector<std::uint32_t> found_, next_;
};

/// A least-squares fit of 1, x, y, z, x²/2, xy, y²/2, xz, yz, z²/2 by modified Gram-Schmidt (Björck 1967), which is as
/// stable as Householder's method when the right-hand side is one of its columns.
class QuadraticFit {
 public:
  void reset(std::size_t rows) {
    rows_ = rows;
    for (std::vector<double>& column : columns_) column.resize(rows);
  }
  void set_row(std::size_t row, const Vec3& x, double value, double weight) {
    const std::array<double, kUnknowns + 1> entries{
        1, x.x, x.y, x.z, x.x * x.x / 2, x.x * x.y, x.y * x.y / 2, x.x * x.z, x.y * x.z, x.z * x.z / 2, value};
    for (std::size_t c = 0; c <= kUnknowns; ++c) columns_[c][row] = weight * entries[c];
  }
  /// A row that pulls a combination of the six second derivatives towards zero.
  void set_penalty(std::size_t row, const std::array<double, 6>& second) {
    for (std::size_t c = 0; c <= kUnknowns; ++c) columns_[c][row] = c >= 4 && c < kUnknowns ? second[c - 4] : 0;
  }
  /// Returns whether all unknowns are determined; those that are not become 0. `least` is what must be left of a
  /// column.
  bool solve(double least, std::array<double, kUnknowns>& unknowns) {
    std::array<std::array<double, kUnknowns + 1>, kUnknowns> r{};
    std::array<bool, kUnknowns> determined{};
    for (std::size_t c = 0; c < kUnknowns; ++c) {
      double* const q = columns_[c].data();
      const double length2 = product(q, q);
      double before = length2;  // of the column before the others were taken out of it
      for (std::size_t earlier = 0; earlier < c; ++earlier) before += r[earlier][c] * r[earlier][c];
      determined[c] = length2 > least * least * before;
      if (!determined[c]) continue;
      r[c][c] = std::sqrt(length2);
      for (std::size_t i = 0; i < rows_; ++i) q[i] /= r[c][c];
      for (std::size_t later = c + 1; later <= kUnknowns; ++later) {
        double* const p = columns_[later].data();
        const double along = r[c][later] = product(q, p);
        for (std::size_t i = 0; i < rows_; ++i) p[i] -= along * q[i];
      }
    }
    for (std::size_t c = kUnknowns; c-- > 0;) {
      unknowns[c] = 0;
      if (!determined[c]) continue;
      double rest = r[c][kUnknowns];
      for (std::size_t later = c + 1; later < kUnknowns; ++later) rest -= r[c][later] * unknowns[later];
      unknowns[c] = rest / r[c][c];
    }
    return std::all_of(determined.begin(), determined.end(), [](bool each) { return each; });
  }

 private:
  double product(const double* a, const double* b) const {
    double even = 0, odd = 0;  // two chains, for speed
    std::size_t i = 0;
    for (; i + 1 < rows_; i += 2) even += a[i] * b[i], odd += a[i + 1] * b[i + 1];
    if (i < rows_) even += a[i] * b[i];
    return even + odd;
  }

  std::size_t rows_ = 0;
  std::array<std::vector<double>, kUnknowns + 1> columns_;  ///< the last one: the values
};

class Recovery {
 public:
  Recovery(std::span<const double> values, const TetView& mesh, const VertexGraph& graph)
      : values_(values), mesh_(mesh), graph_(graph), neighborhood_(graph) {}

  Tensor hessian_at(std::uint32_t vert) {
    if (graph_.neighbors(vert).empty()) return {};
    Tensor hessian;
    if (fit(vert, 2, false, hessian) || fit(vert, 3, false, hessian)) return hessian;
    fit(vert, 3, true, hessian);
    return hessian;
  }

 private:
  bool fit(std::uint32_t vert, int rings, bool penalized, Tensor& hessian) {
    const std::vector<std::uint32_t>& verts = neighborhood_.find(vert, rings);
    const Vec3 center = mesh_.points[vert];
    Tensor covariance;
    for (const std::uint32_t v : verts) covariance += outer(mesh_.points[v] - center);
    const EigenSystem shape = eigen(covariance * (1.0 / static_cast<double>(verts.size())));
    std::array<Vec3, 3> axes;  // of coordinates in which the neighbourhood is about a ball of radius 1
    for (std::size_t i = 0; i < 3; ++i)
      axes[i] = shape.values[i] > 0 ? shape.vectors[i] / std::sqrt(shape.values[i]) : Vec3{};
    fit_.reset(verts.size() + (penalized ? kPenaltyRows : 0));
    for (std::size_t i = 0; i < verts.size(); ++i) {
      const Vec3 e = mesh_.points[verts[i]] - center;
      const Vec3 x{dot(axes[0], e), dot(axes[1], e), dot(axes[2], e)};
      fit_.set_row(i, x, values_[verts[i]] - values_[vert], 1 / std::sqrt(0.1 + norm2(x)));
    }
    const std::array<Tensor, 6> second{outer(axes[0]),
                                       symmetric(axes[0], axes[1]),
                                       outer(axes[1]),
                                       symmetric(axes[0], axes[2]),
                                       symmetric(axes[1], axes[2]),
                                       outer(axes[2])};
    if (penalized) penalize(second, verts.size(), shape.values[0]);
    std::array<double, kUnknowns> found;
    const bool determined = fit_.solve(penalized ? 1e-14 : kDeterminedFit, found);
    hessian = {};
    for (std::size_t i = 0; i < 6; ++i) hessian += found[4 + i] * second[i];
    return determined;
  }

  /// Of all polynomials that fit, the one whose second derivatives in space, not in the scaled coordinates, are least.
  void penalize(const std::array<Tensor, 6>& second, std::size_t row, double shortest2) {
    const double weight = kPenalty * shortest2 * std::sqrt(static_cast<double>(row));
    const double mixed = weight * std::sqrt(2.0);
    const std::array<double Tensor::*, 6> entries{&Tensor::xx, &Tensor::xy, &Tensor::yy,
                                                  &Tensor::xz, &Tensor::yz, &Tensor::zz};
    for (std::size_t e = 0; e < 6; ++e) {
      std::array<double, 6> of_entry;
      for (std::size_t i = 0; i < 6; ++i)
        of_entry[i] = second[i].*entries[e] * (e == 0 || e == 2 || e == 5 ? weight : mixed);
      fit_.set_penalty(row + e, of_entry);
    }
  }

  /// a bᵀ + b aᵀ.
  static Tensor symmetric(const Vec3& a, const Vec3& b) {
    return {2 * a.x * b.x,         a.x * b.y + a.y * b.x, 2 * a.y * b.y,
            a.x * b.z + a.z * b.x, a.y * b.z + a.z * b.y, 2 * a.z * b.z};
  }

  std::span<const double> values_;
  const TetView& mesh_;
  const VertexGraph& graph_;
  Neighborhood neighborhood_;
  QuadraticFit fit_;
};

void require_values(std::span<const double> values, const TetView& mesh) {
  if (values.size() != mesh.points.size())
    throw Error(ErrorCode::InvalidArgument, "a field with " + std::to_string(values.size()) + " values does not fit " +
                                                std::to_string(mesh.points.size()) + " vertices");
  const auto bad = std::find_if(values.begin(), values.end(), [](double value) { return !std::isfinite(value); });
  if (bad == values.end()) return;
  const auto vert = static_cast<std::size_t>(bad - values.begin());
  Diagnostic diagnostic;
  diagnostic.code = ErrorCode::InputUnsuitable;
  diagnostic.message = "the field at vertex " + std::to_string(vert + 1) + " is no finite number";
  diagnostic.point = mesh.points[vert];
  diagnostic.elements = {vert};
  throw Error(std::move(diagnostic));
}

}  // namespace

std::vector<Tensor> recover_hessian(std::span<const double> values, const TetView& mesh, const VertexGraph& graph,
                                    const BlockLoop& loop) {
  require_values(values, mesh);
  std::vector<std::uint32_t> verts(values.size());
  std::iota(verts.begin(), verts.end(), 0u);
  return recover_hessian_at(verts, values, mesh, graph, loop);
}

std::vector<Tensor> recover_hessian_at(std::span<const std::uint32_t> verts, std::span<const double> values,
                                       const TetView& mesh, const VertexGraph& graph, const BlockLoop& loop) {
  std::vector<Tensor> hessians(verts.size());
  loop.for_blocks(verts.size(), kSearchGrain, [&](std::size_t begin, std::size_t end) {
    Recovery recovery(values, mesh, graph);
    for (std::size_t i = begin; i < end; ++i) hessians[i] = recovery.hessian_at(verts[i]);
  });
  return hessians;
}

}  // namespace tetloom::adapt
