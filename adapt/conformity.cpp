#include "adapt/conformity.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/grain.hpp"
#include "core/base/grouping.hpp"

namespace tetloom {

namespace adapt {

namespace {

constexpr std::size_t kConformitySlices = 4;  // of the vertices, whose tets are known one slice after the other

MetricConformity nothing_yet() {
  MetricConformity blank;
  blank.shortest = HUGE_VAL, blank.least_quality = HUGE_VAL;
  return blank;
}

// Sums that are not yet divided by their counts.
void add(const MetricConformity& block, MetricConformity& all) {
  all.edges += block.edges, all.unit += block.unit, all.half_to_two += block.half_to_two;
  all.shortest = std::min(all.shortest, block.shortest), all.longest = std::max(all.longest, block.longest);
  all.least_quality = std::min(all.least_quality, block.least_quality), all.mean_quality += block.mean_quality;
  all.complexity += block.complexity;
  for (std::size_t i = 0; i < block.quality_histogram.size(); ++i)
    all.quality_histogram[i] += block.quality_histogram[i];
}

// Once everything is added.
MetricConformity with_means(MetricConformity sums) {
  if (sums.edges == 0) return MetricConformity();
  std::size_t tets = 0;
  for (const std::size_t count : sums.quality_histogram) tets += count;
  sums.unit /= static_cast<double>(sums.edges), sums.half_to_two /= static_cast<double>(sums.edges);
  sums.mean_quality /= static_cast<double>(tets);
  return sums;
}

// Edges that other parts count.
class ForeignEdges {
 public:
  ForeignEdges() = default;
  ForeignEdges(const Part& part, PartId self) {
    const auto& edges = part.boundary.edges;
    for (std::size_t i = 0; i < edges.size(); ++i)
      if (owner_of(edges.copies_of(i), self) != self) edges_.push_back(edges.entities[i]);
  }
  /// Pre: a < b.
  bool has(std::uint32_t a, std::uint32_t b) const {
    return !edges_.empty() && std::binary_search(edges_.begin(), edges_.end(), std::array{a, b});
  }

 private:
  std::vector<std::array<std::uint32_t, 2>> edges_;  // ascending
};

class Measure {
 public:
  /// An edge is counted where the first of its tets is one of the `own`.
  Measure(const TetView& mesh, std::span<const VertexMetric> metrics, const ForeignEdges& foreign, const OwnTets& own,
          const BlockLoop& loop)
      : mesh_(mesh), metrics_(metrics), foreign_(foreign), own_(own), loop_(loop), all_(nothing_yet()) {}

  // Sums that are not yet divided by their counts.
  MetricConformity run() {
    const std::size_t slice = (metrics_.size() / kConformitySlices / kStarGrain + 1) * kStarGrain;
    for (std::size_t first = 0; first < metrics_.size(); first += slice) {
      const std::size_t count = std::min(slice, metrics_.size() - first);
      find_stars(first, count);
      add_blocks(count, [&](std::size_t begin, std::size_t end, MetricConformity& sum) {
        std::vector<EdgeEnd> ends;
        for (std::size_t v = begin; v < end; ++v) add_edges(first + v, stars_[v], ends, sum);
      });
    }
    stars_ = Grouping();
    add_blocks(own_.count_of(mesh_.tets.size()), [&](std::size_t begin, std::size_t end, MetricConformity& sum) {
      for (std::size_t tet = begin; tet < end; ++tet) add_tet(mesh_.tets[own_.first() + tet], sum);
    });
    return all_;
  }

 private:
  struct EdgeEnd {
    std::uint32_t vert, tet;
    auto operator<=>(const EdgeEnd&) const = default;
  };

  template <class Body>
  void add_blocks(std::size_t count, const Body& body) {
    const auto sums = map_blocks(loop_, count, kStarGrain, nothing_yet(),
                                 [&](std::size_t begin, std::size_t end, MetricConformity& result) {
                                   // Neighbouring results share lines of the cache.
                                   MetricConformity sum = nothing_yet();
                                   body(begin, end, sum);
                                   result = sum;
                                 });
    for (const MetricConformity& sum : sums) add(sum, all_);
  }

  // Of the vertices from `first` on.
  void find_stars(std::size_t first, std::size_t count) {
    stars_ = Grouping();
    stars_ = Grouping(count, [&](const auto& visit) {
      loop_.for_blocks(mesh_.tets.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tet = begin; tet < end; ++tet)
          for (const std::uint32_t v : mesh_.tets[tet])
            if (v - first < count) visit(static_cast<std::uint32_t>(tet), v - first);
      });
    });
  }

  // Those to higher vertices.
  void add_edges(std::size_t from, std::span<const std::uint32_t> star, std::vector<EdgeEnd>& ends,
                 MetricConformity& sum) const {
    const auto a = static_cast<std::uint32_t>(from);
    ends.clear();
    for (const std::uint32_t tet : star)
      for (const std::uint32_t v : mesh_.tets[tet])
        if (v > a) ends.push_back({v, tet});
    std::sort(ends.begin(), ends.end());
    const auto same = [](const EdgeEnd& one, const EdgeEnd& other) { return one.vert == other.vert; };
    ends.erase(std::unique(ends.begin(), ends.end(), same), ends.end());
    for (const auto [b, first_tet] : ends) {
      if (foreign_.has(a, b) || first_tet < own_.begin || first_tet >= own_.end) continue;
      const double length = edge_length(metrics_[a].tensor, metrics_[b].tensor, mesh_.points[b] - mesh_.points[a]);
      ++sum.edges;
      sum.unit += length >= std::sqrt(0.5) && length <= std::sqrt(2.0);
      sum.half_to_two += length >= 0.5 && length <= 2;
      sum.shortest = std::min(sum.shortest, length), sum.longest = std::max(sum.longest, length);
    }
  }

  void add_tet(const TetVerts& tet, MetricConformity& sum) const {
    // Metrics of sizes like 1e-60 overflow, and give what is not a number.
    const double cubed = cubed_mean_ratio(mesh_.points, metrics_, tet);
    const double quality = cubed > 0 ? std::cbrt(std::min(cubed, 1.0)) : 0;
    sum.least_quality = std::min(sum.least_quality, quality), sum.mean_quality += quality;
    ++sum.quality_histogram[static_cast<std::size_t>(std::clamp(quality * 10, 0.0, 9.0))];
    const Vec3& x = mesh_.points[tet[0]];
    const double volume =
        std::abs(dot(cross(mesh_.points[tet[1]] - x, mesh_.points[tet[2]] - x), mesh_.points[tet[3]] - x)) / 6;
    for (const std::uint32_t v : tet) sum.complexity += volume / 4 * std::sqrt(metrics_[v].det);
  }

  const TetView& mesh_;
  std::span<const VertexMetric> metrics_;
  const ForeignEdges& foreign_;
  const OwnTets& own_;
  const BlockLoop& loop_;
  MetricConformity all_;
  Grouping stars_;  // tets by some of their vertices
};

std::vector<VertexMetric> metrics_of(const MetricField& metric, const BlockLoop& loop) {
  std::vector<VertexMetric> metrics(metric.size());
  loop.for_blocks(metrics.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Tensor tensor = exp(metric.logs[v]);
      metrics[v] = {tensor, det(tensor)};
    }
  });
  return metrics;
}

// What the ranks have put.
MetricConformity add_up(const std::vector<Bytes>& given) {
  MetricConformity all = nothing_yet();
  for (const Bytes& bytes : given)
    for (const MetricConformity& sums : MessageReader(bytes).get_view<MetricConformity>()) add(sums, all);
  return with_means(all);
}

}  // namespace

MetricConformity conformity_of(const Mesh& mesh, std::span<const VertexMetric> metrics, const BlockLoop& loop) {
  const TetView view = tets_of(mesh);
  return with_means(Measure(view, metrics, {}, {}, loop).run());
}

MetricConformity conformity_of(const PartsWithMetric& parts, const SharedWork& work) {
  const auto local = parts.mesh.local();
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
    std::vector<MetricConformity> sums(local.size());
    work.runner().for_each(local.size(), [&](std::size_t i) {
      const Part& part = parts.mesh.parts.at(local[i]);
      const std::vector<TetVerts> tets = tets_of(part.mesh);
      const TetView view{part.mesh.points.span(), tets};
      sums[i] =
          Measure(view, parts.to_metric.at(local[i]).span(), ForeignEdges(part, local[i]), {}, work.runner()).run();
    });
    writer.put_array(std::span<const MetricConformity>(sums));
  });
  return add_up(given);
}

MetricConformity conformity_of(const MeshSlice& slice, const SharedWork& work) {
  const TetView view = tets_of(slice.mesh);
  const OwnTets own = slice.own_tets(work);
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
    const std::vector<VertexMetric> metrics = metrics_of(slice.metric, work.runner());
    const std::array<MetricConformity, 1> sums{Measure(view, metrics, {}, own, work.runner()).run()};
    writer.put_array(std::span<const MetricConformity>(sums));
  });
  MetricConformity result = add_up(given);
  result.complexity = complexity(slice.metric, view, own, work.runner());
  return result;
}

}  // namespace adapt

MetricConformity measure_conformity(const Mesh& mesh, const adapt::MetricField& metric, const BlockLoop& loop) {
  using namespace adapt;
  MetricConformity result = conformity_of(mesh, metrics_of(metric, loop), loop);
  // The determinants of very small or large sizes are out of range, their logarithms are not.
  if (result.edges > 0) result.complexity = complexity(metric, tets_of(mesh), loop);
  return result;
}

}  // namespace tetloom
