// Metrics that turn faster than elements can.
//
// Sizes h in the directions of the eigenvectors. A unit step along the one of them, i, turns two of them, j and k with
// h_j > h_k, by an angle φ: what has length 1 along j where the step begins has a length of about φ h_j / h_k across
// where it ends. So no element has unit edges at all of its corners where this *turn* is much above 1, however the mesh
// is made. φ is that of the metric between the vertices of a tet, where logarithms are linear, per unit of length; so
// the turn does not depend on how fine the mesh is, as gradation along edges would.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "adapt/metric/own_tets.hpp"
#include "core/base/grain.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {
namespace {

constexpr double kMostTurn = 1;
constexpr double kLeastGap = 1;    // of logarithms: sizes within a factor of 1.6 are as good as equal
constexpr double kWorthIt = 1.5;   // complexity of the limited metric by that asked for
constexpr double kMostDearer = 4;  // the same, where sizes become larger
constexpr double kDearerTolerance = 1.1;
constexpr int kMostTurnScalings = 12;
constexpr std::size_t kTurningSlices = 8;  // of the vertices, whose tets are known one slice after the other

/// The tets of some vertices, ascending.
class TetsOfVerts {
 public:
  /// Of the vertices from `first` on.
  TetsOfVerts(const TetView& mesh, std::size_t first, std::size_t count) : first_vert_(first), begins_(count + 2, 0) {
    for (const TetVerts& verts : mesh.tets)
      for (const std::uint32_t v : verts)
        if (v - first < count) ++begins_[v - first + 2];
    for (std::size_t v = 2; v < begins_.size(); ++v) begins_[v] += begins_[v - 1];
    tets_.resize(begins_.back());
    // begins_[v + 1] is where the next tet of v goes, and ends up as the end of v's.
    for (std::uint32_t tet = 0; tet < mesh.tets.size(); ++tet)
      for (const std::uint32_t v : mesh.tets[tet])
        if (v - first < count) tets_[begins_[v - first + 1]++] = tet;
  }
  std::span<const std::uint32_t> at(std::size_t vert) const {
    const std::size_t v = vert - first_vert_;
    return std::span(tets_).subspan(begins_[v], begins_[v + 1] - begins_[v]);
  }

 private:
  std::size_t first_vert_;
  std::vector<std::size_t> begins_;
  std::vector<std::uint32_t> tets_;
};

/// How the logarithm of the metric changes over a step inside of a tet.
class Slope {
 public:
  Slope(const MetricField& metric, const TetView& mesh, const TetVerts& v) {
    const Vec3 x = mesh.points[v[0]];
    const Vec3 p = mesh.points[v[1]] - x, q = mesh.points[v[2]] - x, r = mesh.points[v[3]] - x;
    const double det = dot(cross(p, q), r);
    gradients_ = {cross(q, r) / det, cross(r, p) / det, cross(p, q) / det};
    for (std::size_t i = 0; i < 3; ++i) changes_[i] = metric.logs[v[i + 1]] - metric.logs[v[0]];
  }
  Tensor over(const Vec3& step) const {
    return dot(step, gradients_[0]) * changes_[0] + dot(step, gradients_[1]) * changes_[1] +
           dot(step, gradients_[2]) * changes_[2];
  }

 private:
  std::array<Vec3, 3> gradients_;
  std::array<Tensor, 3> changes_;
};

/// The sizes of a metric, and what they may be at most for its turns.
class VertexSizes {
 public:
  /// Sizes above `largest` count as that.
  VertexSizes(const Tensor& logarithm, double largest) : eigen_(eigen(logarithm)) {
    for (std::size_t i = 0; i < 3; ++i) sizes_[i] = std::min(std::exp(-0.5 * eigen_.values[i]), largest);
  }

  void limit(const Slope& slope) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Tensor change = slope.over(sizes_[i] * eigen_.vectors[i]);
      for (std::size_t k = 1; k < 3; ++k) {
        for (std::size_t j = 0; j < k; ++j) {
          const double gap = 2 * std::log(sizes_[j] / sizes_[k]);
          if (!(gap >= kLeastGap)) continue;
          const double angle = std::abs(dot(eigen_.vectors[j], change * eigen_.vectors[k])) / gap;
          const double turn = angle * 2 * std::sinh(0.5 * gap) / kMostTurn;
          if (turn > 1) limit(i, j, k, turn);
        }
      }
    }
  }

  bool is_limited() const { return shares_ != std::array<double, 3>{1, 1, 1}; }

  Tensor limited_log() const {
    EigenSystem result = eigen_;
    for (std::size_t i = 0; i < 3; ++i)
      if (shares_[i] > 1) result.values[i] = std::max(result.values[i], 2 * std::log(shares_[i] / sizes_[i]));
    return compose(result);
  }

 private:
  // The turn is proportional to the sizes i and j. The smallest size stays.
  void limit(std::size_t i, std::size_t j, std::size_t k, double turn) {
    const auto divide = [&](std::size_t n, double by) {
      shares_[n] = std::max(shares_[n], std::min(by, sizes_[n] / sizes_[2]));
    };
    if (i == k) return divide(j, turn);
    divide(i, std::sqrt(turn)), divide(j, std::sqrt(turn));
  }

  EigenSystem eigen_;
  std::array<double, 3> sizes_, shares_{1, 1, 1};  // what sizes are divided by
};

/// Not below the difference of the largest and the smallest eigenvalue.
double spread(const Tensor& m) {
  const double mean = trace(m) / 3, x = m.xx - mean, y = m.yy - mean, z = m.zz - mean;
  return std::sqrt(2 * (x * x + y * y + z * z + 2 * (m.xy * m.xy + m.xz * m.xz + m.yz * m.yz)));
}

class Turning {
 public:
  Turning(const TetView& mesh, const OwnTets& own, const BlockLoop& loop)
      : mesh_(mesh), own_(own), loop_(loop), largest_(box_of_all().diagonal()) {}

  /// The metric within its limits; nothing where it is already, on all ranks.
  std::optional<MetricField> limited_anywhere(const MetricField& metric) const {
    std::optional<MetricField> result = limited(metric);
    if (own_.largest_of(result ? 1 : 0) > 0 && !result) result = metric;
    return result;
  }

  /// The same of this rank.
  std::optional<MetricField> limited(const MetricField& metric) const {
    std::optional<MetricField> result;
    const std::size_t count = metric.size(),
                      slice = std::max(kStarGrain, (count + kTurningSlices - 1) / kTurningSlices);
    for (std::size_t first = 0; first < count; first += slice)
      limit(metric, first, std::min(slice, count - first), result);
    return result;
  }

  /// No size is larger than the mesh.
  double complexity_of(MetricField metric) const {
    MetricBounds bounds;
    bounds.h_max = largest_;
    apply_bounds(metric, bounds, loop_);
    return complexity(metric, mesh_, own_, loop_);
  }

 private:
  Box3 box_of_all() const {
    Box3 box;
    for (const TetVerts& verts : mesh_.tets)
      for (const std::uint32_t v : verts) box.add(mesh_.points[v]);
    std::array<double, 6> ends{-box.lo.x, -box.lo.y, -box.lo.z, box.hi.x, box.hi.y, box.hi.z};
    if (own_.largest) own_.largest(ends);
    box.lo = {-ends[0], -ends[1], -ends[2]}, box.hi = {ends[3], ends[4], ends[5]};
    return box;
  }

  // Of the vertices from `first` on.
  void limit(const MetricField& metric, std::size_t first, std::size_t count, std::optional<MetricField>& all) const {
    if (!turns_anywhere(metric, first, count)) return;
    const TetsOfVerts tets(mesh_, first, count);
    std::vector<Tensor> logs(metric.logs.begin() + static_cast<std::ptrdiff_t>(first),
                             metric.logs.begin() + static_cast<std::ptrdiff_t>(first + count));
    const auto changed =
        map_blocks(loop_, count, kStarGrain, char{0}, [&](std::size_t begin, std::size_t end, char& any) {
          for (std::size_t v = first + begin; v < first + end; ++v) {
            if (spread(metric.logs[v]) < kLeastGap) continue;
            VertexSizes sizes(metric.logs[v], largest_);
            for (const std::uint32_t tet : tets.at(v)) sizes.limit(Slope(metric, mesh_, mesh_.tets[tet]));
            if (sizes.is_limited()) logs[v - first] = sizes.limited_log(), any = 1;
          }
        });
    if (std::find(changed.begin(), changed.end(), 1) == changed.end()) return;
    if (!all) all = metric;
    std::copy(logs.begin(), logs.end(), all->logs.begin() + static_cast<std::ptrdiff_t>(first));
  }

  static bool turns_anywhere(const MetricField& metric, std::size_t first, std::size_t count) {
    for (std::size_t v = first; v < first + count; ++v)
      if (!(spread(metric.logs[v]) < kLeastGap)) return true;
    return false;
  }

  const TetView& mesh_;
  const OwnTets& own_;
  const BlockLoop& loop_;
  double largest_ = 0;
};

}  // namespace

TurningResult limit_turning(MetricField& metric, const TetView& mesh, const BlockLoop& loop) {
  return limit_turning(metric, mesh, OwnTets(), loop);
}

TurningResult limit_turning(MetricField& metric, const TetView& mesh, const OwnTets& own, const BlockLoop& loop) {
  const Turning turning(mesh, own, loop);
  std::optional<MetricField> limited = turning.limited_anywhere(metric);
  if (!limited) return {};
  TurningResult result;
  result.asked = turning.complexity_of(metric), result.followed = turning.complexity_of(*limited);
  if (!(result.followed > kWorthIt * result.asked)) return {};
  result.turns = true;
  const MetricField base = std::exchange(metric, *std::move(limited));
  double shift = 0;
  for (int scaling = 0; scaling < kMostTurnScalings; ++scaling) {
    const double dearer = result.followed / (kMostDearer * result.asked);
    if (dearer <= kDearerTolerance) break;
    shift -= 2.0 / 3 * std::log(dearer);
    metric = base;
    for (Tensor& logarithm : metric.logs) logarithm += diagonal(shift, shift, shift);
    if ((limited = turning.limited(metric))) metric = *std::move(limited);
    result.followed = turning.complexity_of(metric);
  }
  return result;
}

}  // namespace tetloom::adapt
