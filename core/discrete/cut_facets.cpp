#include "core/discrete/cut_facets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/base/lists.hpp"
#include "core/predicates/predicates.hpp"
#include "core/spatial/along_axis.hpp"
#include "core/spatial/constrained_delaunay.hpp"

namespace tetloom::detail {
namespace {

using FacetPair = std::array<std::uint32_t, 2>;    // ascending
using FacetTriple = std::array<std::uint32_t, 3>;  // ascending
using Segment2 = std::array<std::uint32_t, 2>;

/// What two facets have in common: points in the order in which they lie on the segment.
using Chain = std::vector<std::uint32_t>;

FacetPair pair_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

/// Space seen along the axis that is nearest to a facet's normal, so that the facet keeps its orientation.
class FacetPlane {
 public:
  explicit FacetPlane(const Vec3& normal) : axis_(nearest_axis(normal)), is_turned_(normal[axis_] < 0) {}

  Vec2 operator()(const Vec3& p) const {
    const Vec2 seen = without_axis(p, axis_);
    return is_turned_ ? Vec2{seen.v, seen.u} : seen;
  }

 private:
  int axis_;
  bool is_turned_;
};

class FacetCutter {
 public:
  FacetCutter(std::span<const Vec3> points, std::span<const Triangle> tris, const FacetEdges& edges,
              std::span<const FacetPiercing> piercings)
      : tris_(tris), edges_(edges), piercings_(piercings), first_piercing_(points.size()) {
    cut_.points.assign(points.begin(), points.end());
    for (const FacetPiercing& piercing : piercings) cut_.points.push_back(piercing.point);
    segments_of_.resize(tris.size());
  }

  CutFacets run(const CancelToken* cancel) {
    collect_segments();
    join_where_three_meet(cancel);
    for (std::uint32_t tri = 0; tri < tris_.size(); ++tri) {
      check_cancelled(cancel);
      triangulate(tri);
    }
    sort_unique(cut_.in_the_way);
    return std::move(cut_);
  }

 private:
  void put_in_the_way(std::uint32_t tri) {
    cut_.in_the_way.insert(cut_.in_the_way.end(), tris_[tri].begin(), tris_[tri].end());
  }

  std::uint32_t point_of(std::size_t piercing) const { return static_cast<std::uint32_t>(first_piercing_ + piercing); }

  // Two facets that cross have two points on their rims in common; one of them may be a vertex of both.
  void collect_segments() {
    for (std::size_t i = 0; i < piercings_.size(); ++i) {
      for (const std::uint32_t half : edges_.halves(piercings_[i].edge))
        segments_[pair_of(half_to_tri(half), piercings_[i].tri)].push_back(point_of(i));
    }
    for (auto& [pair, segment] : segments_) {
      for (const std::uint32_t v : tris_[pair[0]])
        if (std::ranges::count(tris_[pair[1]], v) > 0) segment.push_back(v);
      if (segment.size() != 2) {
        put_in_the_way(pair[0]), put_in_the_way(pair[1]);
        continue;
      }
      segments_of_[pair[0]].push_back(pair);
      segments_of_[pair[1]].push_back(pair);
    }
  }

  FacetPlane plane_of(std::uint32_t tri) const { return FacetPlane(facet_normal(cut_.points, tris_[tri])); }

  // The share of the segment `first` at which it crosses `second`.
  static std::optional<double> crossing_of(const std::array<Vec2, 2>& first, const std::array<Vec2, 2>& second) {
    const auto crosses = [](const std::array<Vec2, 2>& line, const std::array<Vec2, 2>& ends) {
      return orient2d(line[0], line[1], ends[0]) * orient2d(line[0], line[1], ends[1]) < 0;
    };
    if (!crosses(first, second) || !crosses(second, first)) return {};
    const Vec2 along = second[1] - second[0];
    const double from = cross(along, first[0] - second[0]), to = cross(along, first[1] - second[0]);
    return std::clamp(from / (from - to), 0.0, 1.0);
  }

  // A point where segments cross on a facet belongs to three facets, and to the three segments between them.
  void join_where_three_meet(const CancelToken* cancel) {
    std::map<FacetTriple, std::uint32_t> triples;
    for (std::uint32_t tri = 0; tri < tris_.size(); ++tri) {
      const std::vector<FacetPair>& here = segments_of_[tri];
      if (here.size() < 2) continue;
      check_cancelled(cancel);
      const FacetPlane plane = plane_of(tri);
      std::vector<std::array<Vec2, 2>> flat;
      for (const FacetPair& pair : here) {
        const auto& ends = segments_.at(pair);
        flat.push_back({plane(cut_.points[ends[0]]), plane(cut_.points[ends[1]])});
      }
      for (std::size_t i = 0; i < here.size(); ++i)
        for (std::size_t j = i + 1; j < here.size(); ++j)
          if (const std::optional<double> share = crossing_of(flat[i], flat[j]))
            add_triple(tri, here[i], here[j], *share, triples);
    }
    for (const auto& [triple, point] : triples) put_on_segments(triple, point);
    for (auto& [pair, segment] : segments_) sort_along(segment);
  }

  void add_triple(std::uint32_t tri, const FacetPair& first, const FacetPair& second, double share,
                  std::map<FacetTriple, std::uint32_t>& triples) {
    FacetTriple triple{tri, first[0] == tri ? first[1] : first[0], second[0] == tri ? second[1] : second[0]};
    std::ranges::sort(triple);
    const auto [at, is_new] = triples.try_emplace(triple, static_cast<std::uint32_t>(cut_.points.size()));
    if (!is_new) return;
    const auto& ends = segments_.at(first);
    const Vec3 from = cut_.points[ends[0]], to = cut_.points[ends[1]];
    cut_.points.push_back(from + share * (to - from));
  }

  void put_on_segments(const FacetTriple& triple, std::uint32_t point) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto segment = segments_.find(pair_of(triple[i], triple[(i + 1) % 3]));
      if (segment == segments_.end()) {
        for (const std::uint32_t tri : triple) put_in_the_way(tri);
        return;
      }
      segment->second.push_back(point);
    }
  }

  // The ends come first in what is sorted.
  void sort_along(Chain& segment) const {
    if (segment.size() < 3) return;
    const Vec3 from = cut_.points[segment[0]], along = cut_.points[segment[1]] - from;
    std::ranges::sort(segment, {}, [&](std::uint32_t p) { return dot(along, cut_.points[p] - from); });
  }

  /// The points and segments of one facet, for its triangulation.
  struct Pieces {
    std::vector<std::uint32_t> points;  // ascending
    std::vector<Segment2> segments;     // of positions in `points`
    std::uint32_t place(std::uint32_t point) const {
      return static_cast<std::uint32_t>(std::ranges::lower_bound(points, point) - points.begin());
    }
    // A segment within the facet counts on both of its sides.
    void add_chain(std::span<const std::uint32_t> chain, int times) {
      for (std::size_t i = 1; i < chain.size(); ++i)
        for (int k = 0; k < times; ++k) segments.push_back({place(chain[i - 1]), place(chain[i])});
    }
  };

  // The points on an edge of a facet, with its ends, from the lower vertex on.
  std::vector<std::uint32_t> points_on(std::uint32_t edge) const {
    const auto first = std::ranges::lower_bound(piercings_, edge, {}, &FacetPiercing::edge);
    std::vector<std::pair<double, std::uint32_t>> between;
    for (auto at = first; at != piercings_.end() && at->edge == edge; ++at)
      between.emplace_back(at->share, point_of(static_cast<std::size_t>(at - piercings_.begin())));
    std::ranges::sort(between);
    std::vector<std::uint32_t> chain{edges_.edge_to_vert[edge][0]};
    for (const auto& [share, point] : between) chain.push_back(point);
    chain.push_back(edges_.edge_to_vert[edge][1]);
    return chain;
  }

  Pieces pieces_of(std::uint32_t tri) const {
    std::array<std::vector<std::uint32_t>, 3> rim;
    Pieces pieces;
    const auto add_points = [&](const std::vector<std::uint32_t>& chain) {
      pieces.points.insert(pieces.points.end(), chain.begin(), chain.end());
    };
    for (std::uint32_t i = 0; i < 3; ++i) add_points(rim[i] = points_on(edges_.half_to_edge[3 * tri + i]));
    for (const FacetPair& pair : segments_of_[tri]) add_points(segments_.at(pair));
    sort_unique(pieces.points);
    for (const auto& chain : rim) pieces.add_chain(chain, 1);
    for (const FacetPair& pair : segments_of_[tri]) pieces.add_chain(segments_.at(pair), 2);
    return pieces;
  }

  void triangulate(std::uint32_t tri) {
    if (segments_of_[tri].empty()) {
      cut_.tris.push_back(tris_[tri]);
      cut_.tri_to_cut.push_back(tri);
      return;
    }
    const Pieces pieces = pieces_of(tri);
    const FacetPlane plane = plane_of(tri);
    std::vector<Vec2> flat;
    for (const std::uint32_t point : pieces.points) flat.push_back(plane(cut_.points[point]));
    const PolygonTriangulation made = tetloom::triangulate_polygon(flat, pieces.segments);
    if (made.verdict != PolygonVerdict::Ok) return put_in_the_way(tri);
    for (std::uint32_t t = 0; t < made.triangulation.slots(); ++t) {
      const auto [a, b, c] = made.triangulation.triangle(t);
      cut_.tris.push_back({pieces.points[a], pieces.points[b], pieces.points[c]});
      cut_.tri_to_cut.push_back(tri);
    }
  }

  std::span<const Triangle> tris_;
  const FacetEdges& edges_;
  std::span<const FacetPiercing> piercings_;
  std::size_t first_piercing_;
  std::map<FacetPair, Chain> segments_;
  std::vector<std::vector<FacetPair>> segments_of_;  // per facet
  CutFacets cut_;
};

}  // namespace

CutFacets cut_facets(std::span<const Vec3> points, std::span<const Triangle> tris, const FacetEdges& edges,
                     std::span<const FacetPiercing> piercings, const CancelToken* cancel) {
  return FacetCutter(points, tris, edges, piercings).run(cancel);
}

}  // namespace tetloom::detail
