#include "core/discrete/uncross.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/disjoint_sets.hpp"
#include "core/base/lists.hpp"
#include "core/base/mix_bits.hpp"
#include "core/discrete/cut_facets.hpp"
#include "core/discrete/facet_edges.hpp"
#include "core/discrete/facet_piercings.hpp"

namespace tetloom::detail {
namespace {

constexpr int kAttempts = 12;
constexpr double kSmallestMove = 1e-12;  // of the diagonal; twice as far in every further attempt
constexpr double kMostDoubt = 0.05;      // of a winding number, beside a whole one

double random_share(std::uint64_t seed) {  // from -1 to 1
  return static_cast<double>(static_cast<std::int64_t>(mix_bits((seed + 1) * 0x9e3779b97f4a7c15u))) * 0x1p-63;
}

// Where facets touch there is no telling on which side of each other they lie: vertices move a little, always the same.
void move_a_little(std::span<const std::uint32_t> verts, double step, int attempt, std::vector<Vec3>& points) {
  for (const std::uint32_t v : verts)
    for (int axis = 0; axis < 3; ++axis)
      points[v][axis] += step * random_share((std::uint64_t{v} << 8) + static_cast<std::uint64_t>(3 * attempt + axis));
}

// Pieces that are joined by edges of two facets.
DisjointSets find_patches(const CutFacets& cut) {
  const FacetEdges edges = find_edges(cut.tris, cut.points.size());
  DisjointSets patches(cut.tris.size());
  for (std::size_t edge = 0; edge < edges.size(); ++edge)
    if (const auto halves = edges.halves(edge); halves.size() == 2)
      patches.join(half_to_tri(halves[0]), half_to_tri(halves[1]));
  return patches;
}

// A facet has the winding number of its front before it and one more behind it: in its plane it is the mean of both.
// Nothing where that is no whole number and a half.
std::optional<bool> parts_inside_from_outside(std::span<const Vec3> points, std::span<const Triangle> tris,
                                              std::uint32_t tri) {
  const auto& [a, b, c] = tris[tri];
  const double winding = winding_number(points, tris, (points[a] + points[b] + points[c]) / 3, tri);
  const double in_front = std::round(winding - 0.5);
  if (!(std::abs(winding - 0.5 - in_front) <= kMostDoubt)) return {};
  return in_front == 0;
}

// Whether each piece stays; nothing where that is in doubt. A patch is judged by its largest piece.
std::optional<std::vector<bool>> find_kept(const CutFacets& cut, const CancelToken* cancel) {
  DisjointSets patches = find_patches(cut);
  std::vector<std::uint32_t> largest(cut.tris.size(), kNone);  // per patch
  const auto area = [&](std::uint32_t t) { return norm(facet_normal(cut.points, cut.tris[t])); };
  for (std::uint32_t t = 0; t < cut.tris.size(); ++t)
    if (std::uint32_t& best = largest[patches.find(t)]; best == kNone || area(t) > area(best)) best = t;
  std::vector<bool> kept(cut.tris.size());
  for (std::uint32_t t = 0; t < kept.size(); ++t) {
    const std::uint32_t patch = patches.find(t);
    if (patch < t) {  // judged before
      kept[t] = kept[patch];
      continue;
    }
    check_cancelled(cancel);
    const std::optional<bool> verdict = parts_inside_from_outside(cut.points, cut.tris, largest[patch]);
    if (!verdict) return {};
    kept[t] = *verdict;
  }
  return kept;
}

// Whether as many facets run along every edge one way as the other.
bool is_closed(std::span<const Triangle> tris, std::size_t point_count) {
  const FacetEdges edges = find_edges(tris, point_count);
  for (std::size_t edge = 0; edge < edges.size(); ++edge) {
    int balance = 0;
    for (const std::uint32_t half : edges.halves(edge))
      balance += half_origin(tris, half) == edges.edge_to_vert[edge][0] ? 1 : -1;
    if (balance != 0) return false;
  }
  return true;
}

// The corners of the facets that others pass through.
std::vector<std::uint32_t> find_pierced_verts(std::span<const FacetPiercing> piercings,
                                              std::span<const Triangle> tris) {
  std::vector<std::uint32_t> verts;
  for (const FacetPiercing& piercing : piercings)
    verts.insert(verts.end(), tris[piercing.tri].begin(), tris[piercing.tri].end());
  sort_unique(verts);
  return verts;
}

std::optional<UncrossedFacets> select(CutFacets&& cut, const CancelToken* cancel) {
  const std::optional<std::vector<bool>> kept = find_kept(cut, cancel);
  if (!kept) return {};
  UncrossedFacets result;
  for (std::size_t t = 0; t < cut.tris.size(); ++t) {
    if (!(*kept)[t]) continue;
    result.tris.push_back(cut.tris[t]);
    result.tri_to_cut.push_back(cut.tri_to_cut[t]);
  }
  if (result.tris.empty()) return {};
  result.points = std::move(cut.points);
  return result;
}

}  // namespace

double winding_number(std::span<const Vec3> points, std::span<const Triangle> tris, const Vec3& point,
                      std::uint32_t left_out) {
  double angle = 0;  // half of the solid angle
  for (std::uint32_t tri = 0; tri < tris.size(); ++tri) {
    if (tri == left_out) continue;
    const auto& [i, j, k] = tris[tri];
    const Vec3 a = points[i] - point, b = points[j] - point, c = points[k] - point;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    angle += std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return angle / (2 * std::numbers::pi);
}

std::optional<UncrossedFacets> uncross_facets(std::span<const Vec3> points, std::span<const Triangle> tris,
                                              const CancelToken* cancel) {
  const Box3 box = box_of(points);
  std::vector<Vec3> moved(points.begin(), points.end());
  const FacetEdges edges = find_edges(tris, points.size());
  double step = kSmallestMove * box.diagonal();
  for (int attempt = 0; attempt < kAttempts; ++attempt, step *= 2) {
    const FacetPiercings piercings = find_piercings(moved, tris, edges, cancel);
    if (piercings.all.empty() && piercings.in_the_way.empty()) return {};
    std::vector<std::uint32_t> in_the_way = piercings.in_the_way;
    if (in_the_way.empty()) {
      CutFacets cut = cut_facets(moved, tris, edges, piercings.all, cancel);
      in_the_way = std::move(cut.in_the_way);
      if (in_the_way.empty()) {
        std::optional<UncrossedFacets> made = select(std::move(cut), cancel);
        if (made && is_closed(made->tris, made->points.size())) return made;
        in_the_way = find_pierced_verts(piercings.all, tris);
      }
    }
    move_a_little(in_the_way, step, attempt, moved);
  }
  return {};
}

}  // namespace tetloom::detail
