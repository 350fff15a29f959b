#pragma once
// Where the metric of a new or moved vertex comes from.
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "adapt/metric/background.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::adapt {

using MetricFunction = std::function<Tensor(const Vec3&)>;

/// `asked`, with sizes of at least 1 / `ratio` of those of the metric that has the logarithm `implied`.
Tensor limited(const Tensor& asked, const Tensor& implied, double ratio);
/// By how much the sizes asked for are smaller than those of that metric, in the worst direction.
double refinement_of(const Tensor& asked, const Tensor& implied);

/// The metric asked for, limited to sizes that the mesh at hand can follow: in every direction at least 1 / `ratio` of
/// those of the mesh that adaptation starts from. So a mesh is led to a metric in steps in each of which it stays near
/// a unit mesh, where qualities and lengths mean what they say (as the metrics of Omega_h and of Park & Darmofal 2008
/// approach theirs).
/// Thread safety: immutable; asked by many threads at once.
class MetricStage {
 public:
  /// `implied`: the logarithms of the metrics in which the background's tets are unit, at its vertices. `function`: the
  /// metric asked for; empty: that of the background. All must outlive this.
  MetricStage(const BackgroundMesh& background, const std::vector<Tensor>& implied, const MetricFunction& function,
              double ratio)
      : background_(background), implied_(implied), function_(function), ratio_(ratio) {}

  /// Whether places are looked up in the background at all.
  bool looks_up() const { return !function_ || std::isfinite(ratio_); }
  /// The metric at `x`. `hint` is a tet of the background near there, or kNoTet; afterwards the one that has `x`.
  Tensor at(const Vec3& x, BackgroundTet& hint) const;
  /// By how much the sizes asked for at `x` are smaller than those that the mesh started with, in the worst direction.
  double refinement_at(const Vec3& x, BackgroundTet& hint) const;

 private:
  Tensor asked_at(const Vec3& x, const BackgroundPlace& place) const;
  Tensor implied_log_at(const BackgroundPlace& place) const;

  const BackgroundMesh& background_;
  const std::vector<Tensor>& implied_;
  const MetricFunction& function_;
  double ratio_;
};

/// The logarithms of the implied metric at the vertices of a mesh: the mean over their tets, by volume, of those in
/// which the tets are regular with edges of length 1. Tets may be given some at a time, in their order.
class ImpliedMetric {
 public:
  explicit ImpliedMetric(std::size_t points) : logs_(points), volumes_(points, 0) {}
  /// Pre: positive volumes.
  void add(const TetView& some, const BlockLoop& loop);
  std::vector<Tensor> finish();

 private:
  std::vector<Tensor> logs_;
  std::vector<double> volumes_;
};

/// That of a whole mesh.
std::vector<Tensor> implied_metric(const TetView& mesh, const BlockLoop& loop = serial_loop());

}  // namespace tetloom::adapt
