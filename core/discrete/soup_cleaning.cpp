// Cleaning in this order: reject what cannot be facets, merge equal points, drop collapsed and repeated facets, close
// cracks, remove slivers. Every step keeps the order of points and facets, so the result depends on the file alone.
#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "core/base/mix_bits.hpp"
#include "core/discrete/facet_edges.hpp"
#include "core/discrete/facet_soup.hpp"
#include "core/discrete/needles.hpp"
#include "core/discrete/open_rims.hpp"

namespace tetloom::detail {
namespace {

using VertexMap = std::vector<std::uint32_t>;

constexpr double kAbsurdCoordinate = 1e100;
/// Facets thinner than this share of the bounding box's diagonal have no meaningful normal: it is twice what single
/// precision, which STL is written in, can resolve there.
constexpr double kSliverHeight = 2.5e-7;

void check_coordinates(const FacetSoup& soup) {
  for (const Vec3& p : soup.points) {
    const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    if (is_finite(p) && largest <= kAbsurdCoordinate) continue;
    throw Error(ErrorCode::InputUnsuitable,
                "a facet has a coordinate that is not a finite number or is absurdly large");
  }
}

void check_not_empty(const FacetSoup& soup, const char* message) {
  if (soup.tri_to_vert.empty()) throw Error(ErrorCode::InputUnsuitable, message);
  if (soup.tri_to_vert.size() > kNone / 3 - 1) {
    throw Error(ErrorCode::InputUnsuitable, "the file has more facets than a discrete model can hold");
  }
}

std::uint64_t hash_point(const Vec3& p) {
  const auto bits = [](double c) { return std::bit_cast<std::uint64_t>(c + 0.0); };  // + 0.0 turns -0 into +0
  return mix_bits(bits(p.x) ^ mix_bits(bits(p.y) ^ mix_bits(bits(p.z))));
}

/// For each point, the first one that is equal to it.
VertexMap map_to_first_equal(std::span<const Vec3> points) {
  const std::size_t slots = std::bit_ceil(2 * points.size() + 1), mask = slots - 1;
  std::vector<std::uint32_t> table(slots, kNone);
  VertexMap map(points.size());
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    std::size_t slot = hash_point(points[v]) & mask;
    while (table[slot] != kNone && !(points[table[slot]] == points[v])) slot = (slot + 1) & mask;
    if (table[slot] == kNone) table[slot] = v;
    map[v] = table[slot];
  }
  return map;
}

void apply_map(std::vector<Triangle>& tris, const VertexMap& map) {
  for (Triangle& t : tris) t = {map[t[0]], map[t[1]], map[t[2]]};
}

bool is_collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// Removes the facets for which `remove(index)` holds; returns how many.
template <class Predicate>
std::size_t remove_facets(FacetSoup& soup, Predicate&& remove) {
  std::size_t kept = 0;
  for (std::size_t tri = 0; tri < soup.tri_to_vert.size(); ++tri) {
    if (remove(tri)) continue;
    soup.tri_to_vert[kept] = soup.tri_to_vert[tri];
    if (!soup.tri_to_group.empty()) soup.tri_to_group[kept] = soup.tri_to_group[tri];
    ++kept;
  }
  const std::size_t removed = soup.tri_to_vert.size() - kept;
  soup.tri_to_vert.resize(kept);
  if (!soup.tri_to_group.empty()) soup.tri_to_group.resize(kept);
  return removed;
}

}  // namespace

std::size_t remove_collapsed(FacetSoup& soup) {
  return remove_facets(soup, [&](std::size_t tri) { return is_collapsed(soup.tri_to_vert[tri]); });
}

namespace {

/// Of facets with the same three points, whatever their order, the first one stays.
std::size_t remove_duplicates(FacetSoup& soup) {
  const std::size_t slots = std::bit_ceil(2 * soup.tri_to_vert.size() + 1), mask = slots - 1;
  std::vector<Triangle> table(slots, Triangle{kNone, kNone, kNone});
  return remove_facets(soup, [&](std::size_t tri) {
    Triangle key = soup.tri_to_vert[tri];
    std::sort(key.begin(), key.end());
    std::size_t slot = mix_bits(key[0] ^ mix_bits(key[1] ^ mix_bits(key[2]))) & mask;
    while (table[slot][0] != kNone && table[slot] != key) slot = (slot + 1) & mask;
    if (table[slot] == key) return true;
    table[slot] = key;
    return false;
  });
}

void drop_unused_points(FacetSoup& soup) {
  VertexMap map(soup.points.size(), kNone);
  for (const Triangle& t : soup.tri_to_vert) {
    for (const std::uint32_t v : t) map[v] = v;
  }
  std::uint32_t kept = 0;
  for (std::uint32_t v = 0; v < map.size(); ++v) {
    if (map[v] == kNone) continue;
    soup.points[kept] = soup.points[v];
    map[v] = kept++;
  }
  soup.points.resize(kept), soup.points.shrink_to_fit();
  apply_map(soup.tri_to_vert, map);
}

/// Points by cells of a grid as wide as the tolerance, so that those nearby are in 27 cells.
class SoupGrid {
 public:
  SoupGrid(std::span<const Vec3> points, Vec3 origin, double cell) : points_(points), origin_(origin), cell_(cell) {}

  void insert(std::uint32_t v) { cells_.emplace(key(cell_of(points_[v])), v); }

  /// The lowest point within `cell` of point v, or kNone.
  std::uint32_t find_near(std::uint32_t v) const {
    std::uint32_t found = kNone;
    const auto at = cell_of(points_[v]);
    for (int n = 0; n < 27; ++n) {
      const auto [begin, end] = cells_.equal_range(key({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1}));
      for (auto entry = begin; entry != end; ++entry) {
        if (distance(points_[entry->second], points_[v]) <= cell_) found = std::min(found, entry->second);
      }
    }
    return found;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell cell_of(const Vec3& p) const {
    const auto index = [&](int axis) {
      return static_cast<std::int64_t>(std::floor((p[axis] - origin_[axis]) / cell_));
    };
    return {index(0), index(1), index(2)};
  }
  static std::uint64_t key(const Cell& c) {
    return mix_bits(static_cast<std::uint64_t>(c[0]) ^
                    mix_bits(static_cast<std::uint64_t>(c[1]) ^ mix_bits(static_cast<std::uint64_t>(c[2]))));
  }

  std::span<const Vec3> points_;
  Vec3 origin_;
  double cell_;
  std::unordered_multimap<std::uint64_t, std::uint32_t> cells_;
};

/// Points on open edges that lie within `tolerance` of a lower such point are mapped to it.
VertexMap map_cracks(const FacetSoup& soup, const FacetEdges& edges, double tolerance) {
  VertexMap map(soup.points.size());
  std::vector<bool> open(soup.points.size(), false);
  for (std::size_t edge = 0; edge < edges.size(); ++edge) {
    if (edges.halves(edge).size() == 1) open[edges.edge_to_vert[edge][0]] = open[edges.edge_to_vert[edge][1]] = true;
  }
  SoupGrid grid(soup.points, box_of(soup.points).lo, tolerance);
  for (std::uint32_t v = 0; v < map.size(); ++v) {
    const std::uint32_t near = open[v] ? grid.find_near(v) : kNone;
    map[v] = near == kNone ? v : near;
    if (open[v] && near == kNone) grid.insert(v);
  }
  return map;
}

/// Merges points across cracks with growing tolerance, as long as that opens nothing and makes no edge crowded. The
/// largest tolerance must close the surface altogether. Returns how many points were merged.
std::size_t close_cracks(FacetSoup& soup, const CancelToken* cancel) {
  struct Attempt {
    double tolerance;
    bool must_close;
  };
  std::size_t merged = 0;
  FacetEdges edges = find_edges(soup.tri_to_vert, soup.points.size());
  const double diagonal = box_of(soup.points).diagonal();
  for (const Attempt attempt : {Attempt{1e-6, false}, Attempt{1e-5, false}, Attempt{1e-4, true}}) {
    check_cancelled(cancel);
    const std::size_t open = edges.open_count();
    if (open == 0 || diagonal == 0) break;
    const VertexMap map = map_cracks(soup, edges, attempt.tolerance * diagonal);
    std::size_t moved = 0;
    for (std::uint32_t v = 0; v < map.size(); ++v) moved += map[v] != v;
    if (moved == 0) continue;
    FacetSoup trial{soup.points, soup.tri_to_vert, soup.tri_to_group, {}, {}};
    apply_map(trial.tri_to_vert, map);
    remove_collapsed(trial), remove_duplicates(trial);
    FacetEdges trial_edges = find_edges(trial.tri_to_vert, trial.points.size());
    const std::size_t left = trial_edges.open_count();
    if (trial.tri_to_vert.empty() || left >= open || (attempt.must_close && left > 0)) continue;
    if (trial_edges.crowded_count() > edges.crowded_count()) continue;
    soup.tri_to_vert = std::move(trial.tri_to_vert), soup.tri_to_group = std::move(trial.tri_to_group);
    edges = std::move(trial_edges), merged += moved;
  }
  return merged;
}

/// Merges the ends of edges shorter than `length`. Returns how many points disappeared.
std::size_t collapse_short_edges(FacetSoup& soup, double length) {
  VertexMap map(soup.points.size());
  for (std::uint32_t v = 0; v < map.size(); ++v) map[v] = v;
  const auto root = [&](std::uint32_t v) {
    while (map[v] != v) v = map[v];
    return v;
  };
  std::size_t merged = 0;
  for (const Triangle& t : soup.tri_to_vert) {
    for (int i = 0; i < 3; ++i) {
      if (distance(soup.points[t[i]], soup.points[t[(i + 1) % 3]]) > length) continue;
      const std::uint32_t a = root(t[i]), b = root(t[(i + 1) % 3]);
      if (a == b || distance(soup.points[a], soup.points[b]) > length) continue;
      map[std::max(a, b)] = std::min(a, b);
      ++merged;
    }
  }
  if (merged == 0) return 0;
  for (std::uint32_t v = 0; v < map.size(); ++v) map[v] = root(v);
  apply_map(soup.tri_to_vert, map);
  return merged;
}

/// Which corner of a sliver lies on its opposite edge; -1 for a facet that is no sliver.
///
///      d               d           A sliver a, b, c has its middle corner b on the edge c→a. It goes away when
///     / \             /|\          that edge is swapped for b–d, d being the facet on the other side.
///    /   \    →      / | \         .
///   a──b──c         a──b──c
int find_middle_corner(const FacetSoup& soup, std::size_t tri, double height) {
  const Triangle& t = soup.tri_to_vert[tri];
  int middle = 0;
  double longest = 0;
  for (int i = 0; i < 3; ++i) {
    const double length = distance(soup.points[t[(i + 1) % 3]], soup.points[t[(i + 2) % 3]]);
    if (length > longest) longest = length, middle = i;
  }
  return norm(facet_normal(soup.points, t)) <= height * longest ? middle : -1;
}

/// One round over all slivers whose surroundings no other one has changed. Slivers to be removed are collapsed.
std::size_t swap_slivers_once(FacetSoup& soup, double height) {
  std::vector<std::pair<std::uint32_t, int>> slivers;
  for (std::uint32_t tri = 0; tri < soup.tri_to_vert.size(); ++tri) {
    if (const int middle = find_middle_corner(soup, tri, height); middle >= 0) slivers.emplace_back(tri, middle);
  }
  if (slivers.empty()) return 0;
  const FacetEdges edges = find_edges(soup.tri_to_vert, soup.points.size());
  std::vector<bool> touched(soup.tri_to_vert.size(), false);
  std::size_t removed = 0;
  for (const auto& [tri, middle] : slivers) {
    const std::uint32_t half = 3 * tri + (middle + 1) % 3;
    const auto around = edges.halves(edges.half_to_edge[half]);
    if (touched[tri] || around.size() > 2) continue;
    const std::uint32_t b = soup.tri_to_vert[tri][middle], c = half_origin(soup.tri_to_vert, half);
    const std::uint32_t a = half_head(soup.tri_to_vert, half);
    if (around.size() == 1) {
      soup.tri_to_vert[tri] = {b, b, b}, touched[tri] = true, ++removed;
      continue;
    }
    const std::uint32_t other = edges.twin(half), neighbour = half_to_tri(other);
    const std::uint32_t d = half_origin(soup.tri_to_vert, previous_half(other));
    if (touched[neighbour] || d == b || edges.join(b, d)) continue;
    const bool same_way = half_origin(soup.tri_to_vert, other) == a;  // the two facets are oriented alike
    soup.tri_to_vert[tri] = same_way ? Triangle{a, b, d} : Triangle{b, a, d};
    soup.tri_to_vert[neighbour] = same_way ? Triangle{b, c, d} : Triangle{c, b, d};
    if (!soup.tri_to_group.empty()) soup.tri_to_group[tri] = soup.tri_to_group[neighbour];
    touched[tri] = touched[neighbour] = true, ++removed;
  }
  return removed;
}

std::size_t remove_slivers(FacetSoup& soup, const CancelToken* cancel) {
  constexpr int kRounds = 10;
  const double height = kSliverHeight * box_of(soup.points).diagonal();
  std::size_t removed = 0;
  if (collapse_short_edges(soup, height) > 0) removed += remove_collapsed(soup) + remove_duplicates(soup);
  for (int round = 0; round < kRounds; ++round) {
    check_cancelled(cancel);
    const std::size_t count = swap_slivers_once(soup, height);
    if (count == 0) break;
    removed += count;
    remove_collapsed(soup);
  }
  return removed;
}

}  // namespace

std::vector<HealingStep> clean_soup(FacetSoup& soup, double hole_width, const CancelToken* cancel) {
  check_not_empty(soup, "the file has no facets");
  check_coordinates(soup);
  apply_map(soup.tri_to_vert, map_to_first_equal(soup.points));
  const std::size_t collapsed = remove_collapsed(soup);
  check_cancelled(cancel);
  const std::size_t duplicates = remove_duplicates(soup);
  drop_unused_points(soup);
  check_not_empty(soup, "all facets of the file are degenerate");
  std::size_t merged = close_cracks(soup, cancel);
  const std::size_t junctions = close_t_junctions(soup, cancel);
  // Cracks at the ends of edges that had others' points on them close no edge before.
  if (junctions > 0) merged += close_cracks(soup, cancel);
  const std::size_t needles = collapse_needles(soup, cancel);
  const std::size_t slivers = remove_slivers(soup, cancel);
  check_not_empty(soup, "all facets of the file are degenerate");
  const std::size_t holes = hole_width > 0 ? fill_holes(soup, hole_width, cancel) : 0;
  drop_unused_points(soup);
  std::vector<HealingStep> steps;
  const auto report = [&](const char* what, std::size_t count) {
    if (count > 0) steps.push_back({what, count});
  };
  report("degenerate facets removed", collapsed);
  report("duplicate facets removed", duplicates);
  report("points merged to close cracks", merged);
  report("facets cut where other facets' corners lie on their sides", junctions);
  report("points merged across needles", needles);
  report("slivers thinner than the file's precision removed", slivers);
  report("holes filled", holes);
  return steps;
}

}  // namespace tetloom::detail
