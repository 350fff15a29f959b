#include "core/discrete/creases.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/disjoint_sets.hpp"

namespace tetloom::detail {
namespace {

/// The walls at each point, and what leaves out those that are noise.
class CreaseFilter {
 public:
  CreaseFilter(const FacetSurface& surface, double feature_angle)
      : surface_(surface), walls_(surface.edges.size(), false), crease_(walls_), weak_(walls_) {
    const Box3 box = box_of(surface.points);
    diagonal_ = box.diagonal();
    find_all(std::cos(feature_angle));
    for (std::uint32_t edge = 0; edge < walls_.size(); ++edge) {
      if (walls_[edge]) listed_.push_back(edge);
    }
    collect_incidence();
  }

  std::vector<bool> run() {
    if (std::none_of(listed_.begin(), listed_.end(), [&](std::uint32_t edge) { return crease_[edge]; })) {
      return std::move(walls_);
    }
    drop_small_groups();
    drop_short_branches();
    absorb_small_faces();
    drop_short_branches();
    drop_single_edges();
    return std::move(walls_);
  }

 private:
  static constexpr std::size_t kFewestOfGroup = 6, kFewestOfBranch = 4;
  static constexpr double kWeak = 0.5;                                  // cosine of the turn
  static constexpr double kLongestGroup = 0.03, kLongestBranch = 0.02;  // that is left out, of the diagonal

  double length(std::uint32_t edge) const {
    const auto& ends = surface_.edges.edge_to_vert[edge];
    return distance(surface_.points[ends[0]], surface_.points[ends[1]]);
  }

  void find_all(double least_cosine) {
    std::vector<Vec3> normals;
    normals.reserve(surface_.tri_to_vert.size());
    for (const Triangle& t : surface_.tri_to_vert) normals.push_back(normalized(facet_normal(surface_.points, t)));
    for (std::size_t edge = 0; edge < walls_.size(); ++edge) {
      if (!surface_.edge_is_joint[edge]) {
        walls_[edge] = true;
        continue;
      }
      const auto halves = surface_.edges.halves(edge);
      const std::uint32_t a = half_to_tri(halves[0]), b = half_to_tri(halves[1]);
      const bool flat = normals[a] == Vec3{} || normals[b] == Vec3{};  // a facet without area turns by nothing
      const bool divided = surface_.group(a) != surface_.group(b);
      const double cosine = dot(normals[a], normals[b]);
      crease_[edge] = !divided && !flat && cosine < least_cosine;
      weak_[edge] = crease_[edge] && cosine > kWeak;
      walls_[edge] = divided || crease_[edge];
    }
  }

  void collect_incidence() {
    offset_.assign(surface_.points.size() + 1, 0);
    for (const std::uint32_t edge : listed_) {
      for (const std::uint32_t v : surface_.edges.edge_to_vert[edge]) ++offset_[v + 1];
    }
    for (std::size_t v = 0; v + 1 < offset_.size(); ++v) offset_[v + 1] += offset_[v];
    vert_to_wall_.resize(offset_.back());
    std::vector<std::uint32_t> fill(offset_.begin(), offset_.end() - 1);
    for (const std::uint32_t edge : listed_) {
      for (const std::uint32_t v : surface_.edges.edge_to_vert[edge]) vert_to_wall_[fill[v]++] = edge;
    }
  }

  /// Calls visit(edge) for the walls at a point that are left.
  template <class Visit>
  void for_each_wall(std::uint32_t v, Visit&& visit) const {
    for (std::uint32_t i = offset_[v]; i < offset_[v + 1]; ++i) {
      if (walls_[vert_to_wall_[i]]) visit(vert_to_wall_[i]);
    }
  }
  std::size_t degree(std::uint32_t v) const {
    std::size_t count = 0;
    for_each_wall(v, [&](std::uint32_t) { ++count; });
    return count;
  }

  /// Connected creases of few edges that touch no other wall. Where they part the surface altogether they stay: they
  /// are the edge of a shape of few facets.
  void drop_small_groups() {
    DisjointSets sets(surface_.points.size());
    for (const std::uint32_t edge : listed_) {
      const auto& ends = surface_.edges.edge_to_vert[edge];
      sets.join(ends[0], ends[1]);
    }
    std::vector<std::uint32_t> edges(surface_.points.size(), 0), fixed(surface_.points.size(), 0);
    std::vector<double> lengths(surface_.points.size(), 0);
    for (const std::uint32_t edge : listed_) {
      const std::uint32_t set = sets.find(surface_.edges.edge_to_vert[edge][0]);
      ++edges[set], fixed[set] += !crease_[edge], lengths[set] += length(edge);
    }
    constexpr std::size_t kFewFacets = 32;
    std::vector<std::uint32_t> leaf_to_size(surface_.leaf_count, 0);
    for (const std::uint32_t leaf : surface_.tri_to_leaf) ++leaf_to_size[leaf];
    for (const std::uint32_t edge : listed_) {
      const std::uint32_t set = sets.find(surface_.edges.edge_to_vert[edge][0]);
      const std::uint32_t leaf = surface_.tri_to_leaf[half_to_tri(surface_.edges.halves(edge)[0])];
      const bool small = edges[set] < kFewestOfGroup && lengths[set] < kLongestGroup * diagonal_;
      if (fixed[set] == 0 && small && leaf_to_size[leaf] > kFewFacets) walls_[edge] = false;
    }
  }

  /// Creases of one edge that touch no other wall: the facets on both of its sides share both of its ends, so that no
  /// face could have it twice.
  void drop_single_edges() {
    for (const std::uint32_t edge : listed_) {
      if (!walls_[edge] || !crease_[edge]) continue;
      const auto& ends = surface_.edges.edge_to_vert[edge];
      if (degree(ends[0]) == 1 && degree(ends[1]) == 1) walls_[edge] = false;
    }
  }

  void drop_short_branches() {
    std::vector<std::uint32_t> ends, branch;
    for (std::uint32_t v = 0; v < surface_.points.size(); ++v) {
      if (degree(v) == 1) ends.push_back(v);
    }
    // What a branch leaves behind at its root may be the end of the next one.
    for (std::size_t next = 0; next < ends.size(); ++next) {
      const std::uint32_t root = follow_branch(ends[next], branch);
      if (branch.empty() || branch.size() >= kFewestOfBranch) continue;
      double total = 0;
      for (const std::uint32_t edge : branch) total += length(edge);
      if (total > kLongestBranch * diagonal_) continue;
      for (const std::uint32_t edge : branch) walls_[edge] = false;
      if (degree(root) == 1) ends.push_back(root);
    }
  }

  /// The creases from an end to the first point where walls do not just pass, at most kFewestOfBranch; returns that
  /// point. None where the end is no longer one.
  std::uint32_t follow_branch(std::uint32_t v, std::vector<std::uint32_t>& branch) const {
    branch.clear();
    std::uint32_t before = kNone;
    while (branch.size() < kFewestOfBranch && degree(v) == (before == kNone ? 1 : 2)) {
      std::uint32_t ahead = kNone;
      for_each_wall(v, [&](std::uint32_t edge) { ahead = edge == before ? ahead : edge; });
      if (!crease_[ahead]) break;
      const auto& ends = surface_.edges.edge_to_vert[ahead];
      v = ends[0] == v ? ends[1] : ends[0];
      branch.push_back(ahead), before = ahead;
    }
    return v;
  }

  /// Faces too small to matter, or small and with no crease sharper than 60°, go to the neighbour with which they share
  /// the longest crease, smallest first.
  void absorb_small_faces() {
    constexpr double kWidth = 0.003, kWeakWidth = 0.01;  // of the diagonal
    constexpr std::size_t kFewFacets = 8;
    std::uint32_t count = 0;
    const std::vector<std::uint32_t> faces = flood_between_walls(surface_, walls_, count);
    std::vector<double> area(count, 0);
    std::vector<std::size_t> facets(count, 0);
    for (std::size_t tri = 0; tri < faces.size(); ++tri) {
      area[faces[tri]] += 0.5 * norm(facet_normal(surface_.points, surface_.tri_to_vert[tri])), ++facets[faces[tri]];
    }
    std::vector<double> small(count, std::pow(kWeakWidth * diagonal_, 2));
    for (const std::uint32_t edge : listed_) {
      if (!walls_[edge] || weak_[edge]) continue;
      for (const std::uint32_t half : surface_.edges.halves(edge)) {
        small[faces[half_to_tri(half)]] = std::pow(kWidth * diagonal_, 2);
      }
    }
    std::vector<std::map<std::uint32_t, double>> shared(count);  // by neighbour, of small faces
    for (const std::uint32_t edge : listed_) {
      if (!walls_[edge] || !crease_[edge]) continue;
      const auto halves = surface_.edges.halves(edge);
      const std::array sides{faces[half_to_tri(halves[0])], faces[half_to_tri(halves[1])]};
      if (sides[0] == sides[1]) continue;
      for (int i = 0; i < 2; ++i) {
        if (area[sides[i]] < small[sides[i]] && facets[sides[i]] <= kFewFacets)
          shared[sides[i]][sides[1 - i]] += length(edge);
      }
    }
    std::vector<std::uint32_t> order, into(count);
    for (std::uint32_t face = 0; face < count; ++face) {
      into[face] = face;
      if (!shared[face].empty()) order.push_back(face);
    }
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return area[a] != area[b] ? area[a] < area[b] : a < b; });
    for (const std::uint32_t face : order) {
      double longest = 0;
      for (const auto& [neighbour, length] : shared[face]) {
        if (area[neighbour] >= area[face] && length > longest) longest = length, into[face] = neighbour;
      }
    }
    for (const std::uint32_t edge : listed_) {
      if (!walls_[edge] || !crease_[edge]) continue;
      const auto halves = surface_.edges.halves(edge);
      const std::uint32_t a = faces[half_to_tri(halves[0])], b = faces[half_to_tri(halves[1])];
      if (a != b && (into[a] == b || into[b] == a)) walls_[edge] = false;
    }
  }

  const FacetSurface& surface_;
  double diagonal_ = 0;
  std::vector<bool> walls_, crease_, weak_;
  std::vector<std::uint32_t> listed_, offset_, vert_to_wall_;
};

}  // namespace

std::vector<bool> find_walls(const FacetSurface& surface, double feature_angle) {
  return CreaseFilter(surface, feature_angle).run();
}

std::vector<std::uint32_t> flood_between_walls(const FacetSurface& surface, const std::vector<bool>& walls,
                                               std::uint32_t& count) {
  std::vector<std::uint32_t> tri_to_set(surface.tri_to_vert.size(), kNone), reached;
  count = 0;
  for (std::uint32_t seed = 0; seed < tri_to_set.size(); ++seed) {
    if (tri_to_set[seed] != kNone) continue;
    reached.assign(1, seed);
    tri_to_set[seed] = count;
    while (!reached.empty()) {
      const std::uint32_t tri = reached.back();
      reached.pop_back();
      for (std::uint32_t half = 3 * tri; half < 3 * tri + 3; ++half) {
        if (walls[surface.edges.half_to_edge[half]]) continue;
        const std::uint32_t other = half_to_tri(surface.edges.twin(half));
        if (tri_to_set[other] != kNone) continue;
        tri_to_set[other] = count;
        reached.push_back(other);
      }
    }
    ++count;
  }
  return tri_to_set;
}

}  // namespace tetloom::detail
