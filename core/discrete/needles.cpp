#include "core/discrete/needles.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/base/lists.hpp"
#include "core/discrete/facet_edges.hpp"

namespace tetloom::detail {
namespace {

constexpr double kShortest = 1e-5;  // of the diagonal

/// One round of collapses, no two of which touch the same facet.
class NeedleCollapser {
 public:
  NeedleCollapser(FacetSoup& soup, double length)
      : soup_(soup), length_(length), edges_(find_edges(soup.tri_to_vert, soup.points.size())) {}

  std::size_t run() {
    const std::vector<ShortEdge> candidates = find_short();
    if (candidates.empty()) return 0;
    collect_facets();
    touched_.assign(soup_.points.size(), false);
    std::size_t merged = 0;
    for (const ShortEdge& edge : candidates) merged += collapse(edge.edge);
    return merged;
  }

 private:
  struct ShortEdge {
    double length;
    std::uint32_t edge;
    auto operator<=>(const ShortEdge&) const = default;
  };

  std::vector<ShortEdge> find_short() const {
    std::vector<ShortEdge> found;
    for (std::uint32_t edge = 0; edge < edges_.size(); ++edge) {
      const auto& [a, b] = edges_.edge_to_vert[edge];
      const double length = distance(soup_.points[a], soup_.points[b]);
      if (length < length_ && edges_.halves(edge).size() == 2) found.push_back({length, edge});
    }
    std::sort(found.begin(), found.end());
    return found;
  }

  void collect_facets() {
    offset_.assign(soup_.points.size() + 1, 0);
    for (const Triangle& t : soup_.tri_to_vert) {
      for (const std::uint32_t v : t) ++offset_[v + 1];
    }
    for (std::size_t v = 0; v + 1 < offset_.size(); ++v) offset_[v + 1] += offset_[v];
    facets_.resize(offset_.back());
    std::vector<std::uint32_t> fill(offset_.begin(), offset_.end() - 1);
    for (std::uint32_t tri = 0; tri < soup_.tri_to_vert.size(); ++tri) {
      for (const std::uint32_t v : soup_.tri_to_vert[tri]) facets_[fill[v]++] = tri;
    }
  }

  std::span<const std::uint32_t> facets_at(std::uint32_t v) const {
    return std::span(facets_).subspan(offset_[v], offset_[v + 1] - offset_[v]);
  }

  std::vector<std::uint32_t> around(std::uint32_t v) const {
    std::vector<std::uint32_t> verts;
    for (const std::uint32_t tri : facets_at(v)) {
      for (const std::uint32_t other : soup_.tri_to_vert[tri]) {
        if (other != v) verts.push_back(other);
      }
    }
    sort_unique(verts);
    return verts;
  }

  bool collapse(std::uint32_t edge) {
    auto [keep, drop] = edges_.edge_to_vert[edge];
    if (touched_[keep] || touched_[drop]) return false;
    const std::vector<std::uint32_t> near_keep = around(keep), near_drop = around(drop);
    const auto is_touched = [&](std::uint32_t v) { return touched_[v]; };
    if (std::ranges::any_of(near_keep, is_touched) || std::ranges::any_of(near_drop, is_touched)) return false;
    std::vector<std::uint32_t> both;
    std::ranges::set_intersection(near_keep, near_drop, std::back_inserter(both));
    if (both.size() != 2) return false;  // the link condition
    if (!keeps_facets(keep, drop)) {
      if (!keeps_facets(drop, keep)) return false;
      std::swap(keep, drop);
    }
    for (const std::uint32_t tri : facets_at(drop)) {
      for (std::uint32_t& v : soup_.tri_to_vert[tri]) v = v == drop ? keep : v;
    }
    for (const std::uint32_t v : near_keep) touched_[v] = true;
    for (const std::uint32_t v : near_drop) touched_[v] = true;
    return true;
  }

  /// Whether facets that are no needles face the same way with `keep` in place of `drop`.
  bool keeps_facets(std::uint32_t keep, std::uint32_t drop) const {
    constexpr double kLeastCosine = 0.8;
    return std::ranges::all_of(facets_at(drop), [&](std::uint32_t tri) {
      Triangle t = soup_.tri_to_vert[tri];
      if (std::ranges::find(t, keep) != t.end()) return true;
      const Vec3 before = facet_normal(soup_.points, t);
      if (norm(before) < 2 * length_ * longest_side(t)) return true;
      for (std::uint32_t& v : t) v = v == drop ? keep : v;
      return dot(normalized(before), normalized(facet_normal(soup_.points, t))) > kLeastCosine;
    });
  }

  double longest_side(const Triangle& t) const {
    const auto& p = soup_.points;
    return std::max({distance(p[t[0]], p[t[1]]), distance(p[t[1]], p[t[2]]), distance(p[t[2]], p[t[0]])});
  }

  FacetSoup& soup_;
  double length_;
  FacetEdges edges_;
  std::vector<std::uint32_t> offset_, facets_;
  std::vector<bool> touched_;
};

}  // namespace

std::size_t collapse_needles(FacetSoup& soup, const CancelToken* cancel) {
  constexpr int kRounds = 30;
  constexpr std::size_t kFewest = 4;  // facets of a closed surface
  const Box3 box = box_of(soup.points);
  std::size_t merged = 0;
  for (int round = 0; round < kRounds && soup.tri_to_vert.size() > kFewest; ++round) {
    check_cancelled(cancel);
    const std::size_t count = NeedleCollapser(soup, kShortest * box.diagonal()).run();
    if (count == 0) break;
    merged += count;
    remove_collapsed(soup);
  }
  return merged;
}

}  // namespace tetloom::detail
