// How fast sizes may grow from vertex to vertex.
#include <algorithm>
#include <string>

#include "adapt/metric/own_verts.hpp"
#include "core/base/grain.hpp"
#include "tetloom/error.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {
namespace {

constexpr double kIsotropic = 0.125;          // exponent of growth towards isotropy
constexpr double kGradationTolerance = 2e-3;  // of eigenvalues: 1e-3 of sizes
constexpr double kBand = 1.5;  // of logarithms of determinants: sizes of a round, within a factor of 1.28

/// A metric with what growing it needs.
struct Source {
  Tensor metric;
  EigenSystem eigen_of_log;
};

Source source_of(const Tensor& logarithm) { return {exp(logarithm), eigen(logarithm)}; }

/// By what all sizes grow along the edge `e`.
double kept_growth(const Tensor& metric, const Vec3& e, double log_growth) {
  return std::pow(1 + std::sqrt(std::max(0.0, dot(metric, e))) * log_growth, 1 - kIsotropic);
}

/// The metric as it has grown at the other end of an edge: by `kept` and, small sizes more than large ones, towards
/// isotropy.
Tensor grown(const Source& source, double kept, double length, double log_growth) {
  EigenSystem result = source.eigen_of_log;
  for (double& value : result.values) {
    const double size_inverse = std::exp(0.5 * value);
    const double factor = kept * std::pow(1 + size_inverse * length * log_growth, kIsotropic);
    value = size_inverse * size_inverse / (factor * factor);
  }
  return compose(result);
}

/// Whether `m` has only positive eigenvalues, by the signs of its pivots.
bool has_positive_pivots(const Tensor& m) {
  if (!(m.xx > 0)) return false;
  const double l1 = m.xy / m.xx, l2 = m.xz / m.xx;
  const double yy = m.yy - l1 * m.xy, yz = m.yz - l1 * m.xz;
  return yy > 0 && m.zz - l2 * m.xz - yz * yz / yy > 0;
}

class Gradation {
 public:
  Gradation(MetricField& metric, std::span<const Vec3> points, const VertexGraph& graph, double growth,
            const OwnVerts& own, const BlockLoop& loop)
      : metric_(metric), points_(points), graph_(graph), own_(own), loop_(loop), log_growth_(std::log(growth)) {}

  GradationResult run() {
    const std::size_t count = points_.size();
    sources_.resize(count);
    loop_.for_blocks(count, kStarGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) sources_[v] = source_of(metric_.logs[v]);
    });
    GradationResult result;
    std::vector<char> ever(count, 0);
    pending_.assign(count, 1);
    while (take_smallest()) {
      ++result.rounds;
      std::vector<std::uint32_t> changed = limit(targets());
      if (own_.refresh) {
        const std::vector<std::uint32_t> others = own_.refresh(changed, metric_.logs);
        changed.insert(changed.end(), others.begin(), others.end());
      }
      find_sources(changed);
      for (const std::uint32_t v : changed) ever[v] = pending_[v] = 1;
    }
    result.changed = static_cast<std::size_t>(std::count(ever.begin(), ever.end(), 1));
    return result;
  }

 private:
  struct Limited {
    std::vector<std::uint32_t> verts;
    std::vector<Tensor> metrics;
  };

  /// Makes those of the pending vertices that ask for the smallest elements the sources of a round, so that few are
  /// sources twice: small sizes reach far, and are not changed by larger ones. False when none is pending.
  bool take_smallest() {
    double largest = -HUGE_VAL;
    for (std::size_t v = 0; v < pending_.size(); ++v)
      if (pending_[v]) largest = std::max(largest, trace(metric_.logs[v]));
    if (own_.largest) own_.largest(std::span(&largest, 1));
    is_source_.assign(pending_.size(), 0);
    for (std::size_t v = 0; v < pending_.size(); ++v)
      if (pending_[v] && trace(metric_.logs[v]) >= largest - kBand) is_source_[v] = 1, pending_[v] = 0;
    return largest > -HUGE_VAL;
  }

  /// Intersects the metrics of `targets` with those of their neighbours that are sources. Returns the vertices whose
  /// metric has changed, ascending.
  std::vector<std::uint32_t> limit(const std::vector<std::uint32_t>& targets) {
    const auto blocks = map_blocks(loop_, targets.size(), kStarGrain, Limited(),
                                   [&](std::size_t begin, std::size_t end, Limited& limited) {
                                     for (std::size_t i = begin; i < end; ++i) {
                                       Tensor m = sources_[targets[i]].metric;
                                       if (!limit(targets[i], m)) continue;
                                       limited.verts.push_back(targets[i]);
                                       limited.metrics.push_back(log(m));
                                     }
                                   });
    std::vector<std::uint32_t> verts;
    for (const Limited& limited : blocks)
      for (std::size_t i = 0; i < limited.verts.size(); ++i) {
        verts.push_back(limited.verts[i]);
        metric_.logs[limited.verts[i]] = limited.metrics[i];
      }
    return verts;
  }

  void find_sources(const std::vector<std::uint32_t>& verts) {
    loop_.for_blocks(verts.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) sources_[verts[i]] = source_of(metric_.logs[verts[i]]);
    });
  }

  bool limit(std::uint32_t vert, Tensor& m) const {
    bool changes = false;
    for (const std::uint32_t from : graph_.neighbors(vert)) {
      if (!is_source_[from]) continue;
      // Most neighbours ask for nothing new, which is seen before their growth is known in full.
      const Source& source = sources_[from];
      const Tensor most = (1 + kGradationTolerance) * m;
      if (has_positive_pivots(most - source.metric)) continue;
      const Vec3 e = points_[vert] - points_[from];
      const double kept = kept_growth(source.metric, e, log_growth_);
      if (has_positive_pivots(kept * kept * most - source.metric)) continue;
      const Tensor limiting = grown(source, kept, norm(e), log_growth_);
      if (has_positive_pivots(most - limiting)) continue;
      const Tensor both = intersection(m, limiting);
      changes = changes || both != m;
      m = both;
    }
    return changes;
  }

  /// Own neighbours of sources, ascending.
  std::vector<std::uint32_t> targets() const {
    std::vector<char> is_target(points_.size(), 0);
    for (std::size_t v = 0; v < is_source_.size(); ++v)
      if (is_source_[v])
        for (const std::uint32_t w : graph_.neighbors(v)) is_target[w] = 1;
    std::vector<std::uint32_t> found;
    for (std::size_t v = 0; v < is_target.size(); ++v)
      if (is_target[v] && own_.has(v)) found.push_back(static_cast<std::uint32_t>(v));
    return found;
  }

  MetricField& metric_;
  std::span<const Vec3> points_;
  const VertexGraph& graph_;
  const OwnVerts& own_;
  const BlockLoop& loop_;
  double log_growth_;
  std::vector<Source> sources_;
  std::vector<char> pending_;    ///< changed since the vertex was a source
  std::vector<char> is_source_;  ///< of this round
};

}  // namespace

GradationResult limit_gradation(MetricField& metric, std::span<const Vec3> points, const VertexGraph& graph,
                                double growth, const BlockLoop& loop) {
  return limit_gradation(metric, points, graph, growth, OwnVerts(), loop);
}

GradationResult limit_gradation(MetricField& metric, std::span<const Vec3> points, const VertexGraph& graph,
                                double growth, const OwnVerts& own, const BlockLoop& loop) {
  if (!(growth > 1) || !std::isfinite(growth))
    throw Error(ErrorCode::InvalidArgument, "the gradation must be larger than 1, not " + std::to_string(growth));
  return Gradation(metric, points, graph, growth, own, loop).run();
}

}  // namespace tetloom::adapt
