#include "core/discrete/open_rims.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/disjoint_sets.hpp"
#include "core/base/lists.hpp"
#include "core/discrete/polygon.hpp"

namespace tetloom::detail {
namespace {

/// One round of cuts at T-junctions, at most one edge of each facet.
class JunctionCutter {
 public:
  JunctionCutter(FacetSoup& soup, const FacetEdges& edges, double tolerance)
      : soup_(soup), edges_(edges), tolerance_(tolerance) {}

  std::size_t run() {
    std::vector<std::uint32_t> open;
    for (std::uint32_t edge = 0; edge < edges_.size(); ++edge) {
      if (edges_.halves(edge).size() == 1) open.push_back(edge);
    }
    for (const std::uint32_t edge : open) {
      for (const std::uint32_t v : edges_.edge_to_vert[edge]) along_x_.push_back({soup_.points[v].x, v});
    }
    sort_unique(along_x_);
    std::vector<bool> done(soup_.tri_to_vert.size(), false);
    std::size_t cuts = 0;
    for (const std::uint32_t edge : open) {
      const std::uint32_t half = edges_.halves(edge)[0], tri = half_to_tri(half);
      if (done[tri]) continue;
      const std::vector<std::uint32_t> between = find_between(half);
      if (between.empty()) continue;
      cut(half, between);
      done[tri] = true, ++cuts;
    }
    return cuts;
  }

 private:
  /// Points of open edges inside of the half-edge, in its order.
  std::vector<std::uint32_t> find_between(std::uint32_t half) const {
    const std::uint32_t a = half_origin(soup_.tri_to_vert, half), b = half_head(soup_.tri_to_vert, half);
    const Vec3 &p = soup_.points[a], d = soup_.points[b] - p;
    const double length2 = norm2(d), nearest = tolerance_ / std::sqrt(length2);
    std::vector<std::pair<double, std::uint32_t>> found;
    const std::pair<double, std::uint32_t> first{std::min(p.x, p.x + d.x) - tolerance_, 0};
    for (auto at = std::ranges::lower_bound(along_x_, first); at != along_x_.end(); ++at) {
      if (at->first > std::max(p.x, p.x + d.x) + tolerance_) break;
      const Vec3 offset = soup_.points[at->second] - p;
      const double share = dot(offset, d) / length2;
      if (share <= nearest || share >= 1 - nearest || norm(offset - share * d) > tolerance_) continue;
      const Triangle& t = soup_.tri_to_vert[half_to_tri(half)];
      if (std::ranges::find(t, at->second) == t.end()) found.push_back({share, at->second});
    }
    std::sort(found.begin(), found.end());
    std::vector<std::uint32_t> verts;
    for (const auto& [share, v] : found) verts.push_back(v);
    return verts;
  }

  ///      c           The facet a, b, c becomes a, m, c and m, b, c.
  ///     /|\          .
  ///    a─m─b
  void cut(std::uint32_t half, const std::vector<std::uint32_t>& between) {
    const std::uint32_t tri = half_to_tri(half), c = half_origin(soup_.tri_to_vert, previous_half(half));
    const std::uint32_t end = half_head(soup_.tri_to_vert, half);
    soup_.tri_to_vert[tri] = {half_origin(soup_.tri_to_vert, half), between[0], c};
    for (std::size_t i = 0; i < between.size(); ++i) {
      soup_.tri_to_vert.push_back({between[i], i + 1 < between.size() ? between[i + 1] : end, c});
      if (!soup_.tri_to_group.empty()) soup_.tri_to_group.push_back(soup_.tri_to_group[tri]);
    }
  }

  FacetSoup& soup_;
  const FacetEdges& edges_;
  double tolerance_;
  std::vector<std::pair<double, std::uint32_t>> along_x_;  // points of open edges
};

/// Walks along open edges, around the fans of facets between them, whatever their orientation.
class RimWalker {
 public:
  RimWalker(std::span<const Triangle> tris, const FacetEdges& edges)
      : tris_(tris), edges_(edges), visited_(edges.size(), false) {}

  std::vector<std::vector<std::uint32_t>> run() {
    for (std::uint32_t edge = 0; edge < edges_.size(); ++edge) {
      if (edges_.halves(edge).size() == 1 && !visited_[edge]) walk(edge);
    }
    return std::move(loops_);
  }

 private:
  /// Cuts the walk into loops that pass no point twice.
  void walk(std::uint32_t first) {
    std::vector<std::uint32_t> path{edges_.edge_to_vert[first][0]};
    std::uint32_t edge = first;
    do {
      visited_[edge] = true;
      const auto& ends = edges_.edge_to_vert[edge];
      const std::uint32_t v = ends[0] == path.back() ? ends[1] : ends[0];
      const auto before = std::ranges::find(path, v);
      if (before != path.end()) {
        loops_.emplace_back(before, path.end());
        path.erase(before, path.end());
      }
      path.push_back(v);
      edge = next_open(edge, v);
    } while (edge != kNone && edge != first && !visited_[edge]);
  }

  /// The other open edge of the fan of facets at `v` that `edge` belongs to; kNone where the fan ends otherwise.
  std::uint32_t next_open(std::uint32_t edge, std::uint32_t v) const {
    std::uint32_t tri = half_to_tri(edges_.halves(edge)[0]);
    while (true) {
      for (std::uint32_t half = 3 * tri; half < 3 * tri + 3; ++half) {
        const std::uint32_t other = edges_.half_to_edge[half];
        if (other == edge || (half_origin(tris_, half) != v && half_head(tris_, half) != v)) continue;
        edge = other;
        break;
      }
      const auto halves = edges_.halves(edge);
      if (halves.size() == 1) return edge;
      if (halves.size() > 2) return kNone;
      tri = half_to_tri(halves[0]) == tri ? half_to_tri(halves[1]) : half_to_tri(halves[0]);
    }
  }

  std::span<const Triangle> tris_;
  const FacetEdges& edges_;
  std::vector<bool> visited_;
  std::vector<std::vector<std::uint32_t>> loops_;
};

void fill(FacetSoup& soup, std::vector<std::uint32_t> rim, const FacetEdges& edges) {
  // The filling runs against the facets at the rim.
  const auto first = static_cast<std::size_t>(
      std::ranges::lower_bound(edges.edge_to_vert, std::array{std::min(rim[0], rim[1]), std::max(rim[0], rim[1])}) -
      edges.edge_to_vert.begin());
  const std::uint32_t half = edges.halves(first)[0];
  if (half_origin(soup.tri_to_vert, half) == rim[0]) std::reverse(rim.begin(), rim.end());
  const std::uint32_t group = soup.group(half_to_tri(half));
  std::vector<Vec3> corners;
  for (const std::uint32_t v : rim) corners.push_back(soup.points[v]);
  const auto n = static_cast<std::uint32_t>(rim.size());
  const auto neighbours = [&](std::uint32_t i, std::uint32_t j) { return (i + 1) % n == j || (j + 1) % n == i; };
  std::vector<std::array<std::uint32_t, 3>> triangles = triangulate_polygon(corners);
  const bool meets_others = std::ranges::any_of(triangles, [&](const auto& t) {
    return std::ranges::any_of(std::array{0, 1, 2}, [&](int k) {
      const std::uint32_t i = t[k], j = t[(k + 1) % 3];
      return !neighbours(i, j) && edges.join(rim[i], rim[j]);
    });
  });
  if (meets_others) {
    Vec3 middle;
    for (const Vec3& p : corners) middle += p / static_cast<double>(n);
    rim.push_back(static_cast<std::uint32_t>(soup.points.size()));
    soup.points.push_back(middle);
    triangles.clear();
    for (std::uint32_t i = 0; i < n; ++i) triangles.push_back({i, (i + 1) % n, n});
  }
  for (const auto& [i, j, k] : triangles) {
    soup.tri_to_vert.push_back({rim[i], rim[j], rim[k]});
    if (!soup.tri_to_group.empty()) soup.tri_to_group.push_back(group);
  }
}

}  // namespace

std::size_t close_t_junctions(FacetSoup& soup, const CancelToken* cancel) {
  constexpr double kTolerance = 1e-5;
  constexpr int kRounds = 6;  // a facet has three edges, and what is left of it two; one of them is cut in a round
  std::size_t cuts = 0, best = 0;
  FacetEdges edges = find_edges(soup.tri_to_vert, soup.points.size());
  const std::size_t crowded = edges.crowded_count();
  std::size_t open = edges.open_count();
  const double tolerance = kTolerance * box_of(soup.points).diagonal();
  FacetSoup trial{soup.points, soup.tri_to_vert, soup.tri_to_group, {}, {}};
  for (int round = 0; round < kRounds && open > 0; ++round) {
    check_cancelled(cancel);
    const std::size_t count = JunctionCutter(trial, edges, tolerance).run();
    if (count == 0) break;
    cuts += count;
    edges = find_edges(trial.tri_to_vert, trial.points.size());
    // More edges are open where one side has been cut and the other not yet.
    if (edges.open_count() >= open || edges.crowded_count() > crowded) continue;
    soup.tri_to_vert = trial.tri_to_vert, soup.tri_to_group = trial.tri_to_group;
    open = edges.open_count(), best = cuts;
  }
  return best;
}

std::vector<OpenRim> find_open_rims(std::span<const Vec3> points, const FacetEdges& edges) {
  DisjointSets sets(points.size());
  std::vector<std::uint32_t> open;
  for (std::uint32_t edge = 0; edge < edges.size(); ++edge) {
    if (edges.halves(edge).size() != 1) continue;
    open.push_back(edge);
    sets.join(edges.edge_to_vert[edge][0], edges.edge_to_vert[edge][1]);
  }
  std::vector<OpenRim> rims;
  std::vector<std::uint32_t> set_to_rim(points.size(), kNone);
  std::vector<Box3> boxes;
  for (const std::uint32_t edge : open) {
    const auto& ends = edges.edge_to_vert[edge];
    std::uint32_t& rim = set_to_rim[sets.find(ends[0])];
    if (rim == kNone) {
      rim = static_cast<std::uint32_t>(rims.size());
      rims.push_back({0, 0, 0.5 * (points[ends[0]] + points[ends[1]])});
      boxes.emplace_back();
    }
    ++rims[rim].edges;
    for (const std::uint32_t v : ends) boxes[rim].add(points[v]);
  }
  for (std::size_t rim = 0; rim < rims.size(); ++rim) rims[rim].width = boxes[rim].diagonal();
  return rims;
}

std::size_t fill_holes(FacetSoup& soup, double width, const CancelToken* cancel) {
  const FacetEdges edges = find_edges(soup.tri_to_vert, soup.points.size());
  std::size_t filled = 0;
  for (const std::vector<std::uint32_t>& loop : RimWalker(soup.tri_to_vert, edges).run()) {
    check_cancelled(cancel);
    Box3 box;
    for (const std::uint32_t v : loop) box.add(soup.points[v]);
    if (loop.size() < 3 || box.diagonal() > width) continue;
    fill(soup, loop, edges);
    ++filled;
  }
  return filled;
}

}  // namespace tetloom::detail
