#include "mesher/sizing/misfits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tetloom {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr double kFlatAngle = 15 * std::numbers::pi / 180;
// A new size is worth a new surface where it is smaller by this.
constexpr double kWorthwhile = 0.9;
// A width that is less of the smallest size allowed would leave more poor elements than it found.
constexpr double kHopeless = 0.1;
// Cosines between a ray and what is called the opposite wall.
constexpr double kOpposite = 0.7, kParallel = 0.9998;
// Cosine between model edges that narrow a face towards a corner.
constexpr double kAcute = 0.85;

bool share_a_vertex(const Triangle& s, const Triangle& t) {
  return std::ranges::any_of(s, [&](std::uint32_t v) { return std::ranges::find(t, v) != t.end(); });
}

class MisfitSearch {
 public:
  MisfitSearch(const Mesh& surface, const ModelTopology& topology, const SizeField& sizes,
               const intersection::TriangleTree& tree)
      : mesh_(surface), topology_(topology), sizes_(sizes), tree_(tree) {
    for (auto [a, b] : surface.edge_to_vert) model_pieces_.push_back({std::min(a, b), std::max(a, b)});
    std::ranges::sort(model_pieces_);
    face_to_edges_.resize(topology.face_count());
    for (std::size_t f = 0; f < face_to_edges_.size(); ++f) {
      for (const ModelLoop& loop : topology.face_to_loops[f])
        for (const EdgeUse& use : loop) face_to_edges_[f].push_back(use.edge.value);
      std::ranges::sort(face_to_edges_[f]);
    }
    find_acute_corners();
  }

  /// The size that fits on the triangle, where it is smaller than the present one; else infinity.
  double fitting_size(std::uint32_t triangle, const std::function<double(const Vec3&)>& floor) const {
    const auto [a, b, c] = tree_.corners_of(triangle);
    const Vec3 center = (1.0 / 3) * (a + b + c), normal = normalized(cross(b - a, c - a));
    if (norm2(normal) == 0) return HUGE_VAL;
    const double present = sizes_.size_at(center), reach = kLeastWidth * present;
    double width = height_of_flat(triangle, {a, b, c});
    const FaceSides& sides = topology_.face_to_sides[mesh_.tri_to_entity[triangle]];
    if (sides.front.valid()) width = std::min(width, wall_width(sides.front, triangle, center, reach * normal));
    if (sides.back.valid()) width = std::min(width, wall_width(sides.back, triangle, center, -reach * normal));
    if (width == HUGE_VAL) return HUGE_VAL;
    const double least = floor(center), size = std::max(width / kLeastWidth, least);
    return width >= kHopeless * least && size < kWorthwhile * present ? size : HUGE_VAL;
  }

 private:
  /// Pairs of model edges that meet at less than kAcute, as the mesh has them.
  void find_acute_corners() {
    struct End {
      std::uint32_t corner, edge;
      Vec3 direction;
    };
    std::vector<End> ends;
    for (std::size_t i = 0; i < mesh_.edge_to_vert.size(); ++i) {
      const auto [a, b] = mesh_.edge_to_vert[i];
      const Vec3 along = normalized(mesh_.points[b] - mesh_.points[a]);
      if (mesh_.point_to_entity[a].dim == 0) ends.push_back({a, mesh_.edge_to_entity[i], along});
      if (mesh_.point_to_entity[b].dim == 0) ends.push_back({b, mesh_.edge_to_entity[i], -along});
    }
    std::ranges::stable_sort(ends, {}, &End::corner);
    for (std::size_t i = 0; i < ends.size(); ++i)
      for (std::size_t j = i + 1; j < ends.size() && ends[j].corner == ends[i].corner; ++j)
        if (ends[i].edge != ends[j].edge && dot(ends[i].direction, ends[j].direction) > kAcute)
          acute_pairs_.push_back({std::min(ends[i].edge, ends[j].edge), std::max(ends[i].edge, ends[j].edge)});
    std::ranges::sort(acute_pairs_);
  }

  /// Whether all corners of the triangle lie on two edges of its face that meet at a small angle.
  bool lies_in_acute_corner(std::uint32_t triangle) const {
    const auto& edges = face_to_edges_[mesh_.tri_to_entity[triangle]];
    const auto lies_on = [&](std::uint32_t v, std::uint32_t edge) {
      const ModelEntity at = mesh_.point_to_entity[v];
      if (at.dim == 1) return at.index == edge;
      return at.dim == 0 && std::ranges::any_of(topology_.edges[edge].vertices,
                                                [&](ModelVertexId vertex) { return vertex.value == at.index; });
    };
    const auto holds = [&](const std::array<std::uint32_t, 2>& pair) {
      return std::ranges::binary_search(edges, pair[0]) && std::ranges::binary_search(edges, pair[1]) &&
             std::ranges::all_of(mesh_.tri_to_vert[triangle],
                                 [&](std::uint32_t v) { return lies_on(v, pair[0]) || lies_on(v, pair[1]); });
    };
    for (const std::uint32_t edge : edges) {
      const auto first = std::ranges::lower_bound(acute_pairs_, std::array{edge, std::uint32_t{0}});
      for (auto pair = first; pair != acute_pairs_.end() && (*pair)[0] == edge; ++pair)
        if (holds(*pair)) return true;
    }
    return false;
  }

  /// The least height of a triangle with an angle that is too small and not the model's; else infinity.
  double height_of_flat(std::uint32_t triangle, const std::array<Vec3, 3>& x) const {
    std::array<double, 3> length2{};  // of the edge opposite to each corner
    for (std::size_t i = 0; i < 3; ++i) length2[i] = norm2(x[(i + 2) % 3] - x[(i + 1) % 3]);
    const std::size_t i = std::ranges::min_element(length2) - length2.begin();
    const Vec3 u = x[(i + 1) % 3] - x[i], v = x[(i + 2) % 3] - x[i];
    const double twice_area = norm(cross(u, v));
    if (std::atan2(twice_area, dot(u, v)) >= kFlatAngle) return HUGE_VAL;
    const Triangle& verts = mesh_.tri_to_vert[triangle];
    if (is_model_piece(verts[i], verts[(i + 1) % 3]) && is_model_piece(verts[i], verts[(i + 2) % 3])) return HUGE_VAL;
    if (lies_in_acute_corner(triangle)) return HUGE_VAL;
    return twice_area / std::sqrt(std::ranges::max(length2));
  }

  bool is_model_piece(std::uint32_t a, std::uint32_t b) const {
    return std::ranges::binary_search(model_pieces_, std::array{std::min(a, b), std::max(a, b)});
  }

  /// How far from `x`, on a triangle, the first opposite wall of the region within `ray` is, or infinity. Walls of
  /// others do not count: solids may touch.
  double wall_width(ModelRegionId region, std::uint32_t triangle, const Vec3& x, const Vec3& ray) const {
    double nearest = 1;
    bool is_wall = false;
    const Triangle& own = mesh_.tri_to_vert[triangle];
    tree_.for_each_along(x, ray, [&](std::uint32_t other) {
      if (other == triangle || share_a_vertex(own, mesh_.tri_to_vert[other])) return;
      const double at = crossing(other, x, ray);
      // Of triangles at the same distance any may come first: they share the edge or vertex that is hit.
      if (at >= nearest || near_region(other, ray) != region) return;
      nearest = at;
      is_wall = is_opposite(triangle, other, ray);
    });
    return is_wall ? nearest * norm(ray) : HUGE_VAL;
  }

  /// The share of the ray up to a triangle (closed), after Möller & Trumbore (1997); 2 where it is not met.
  double crossing(std::uint32_t triangle, const Vec3& x, const Vec3& ray) const {
    constexpr double kEdge = 1e-9;
    const auto [a, b, c] = tree_.corners_of(triangle);
    const Vec3 p = cross(ray, c - a);
    const double det = dot(b - a, p);
    if (det == 0) return 2;
    const Vec3 s = x - a, q = cross(s, b - a);
    const double u = dot(s, p) / det, v = dot(ray, q) / det, at = dot(c - a, q) / det;
    return u >= -kEdge && v >= -kEdge && u + v <= 1 + kEdge && at > 0 && at <= 1 ? at : 2;
  }

  /// The region that the ray leaves at a triangle.
  ModelRegionId near_region(std::uint32_t triangle, const Vec3& ray) const {
    const auto [a, b, c] = tree_.corners_of(triangle);
    const FaceSides& sides = topology_.face_to_sides[mesh_.tri_to_entity[triangle]];
    return dot(cross(b - a, c - a), ray) < 0 ? sides.front : sides.back;
  }

  bool is_opposite(std::uint32_t triangle, std::uint32_t other, const Vec3& ray) const {
    const auto [a, b, c] = tree_.corners_of(other);
    const double facing = std::abs(dot(normalized(cross(b - a, c - a)), normalized(ray)));
    return facing >
           (meet_at_an_edge(mesh_.tri_to_entity[triangle], mesh_.tri_to_entity[other]) ? kParallel : kOpposite);
  }

  bool meet_at_an_edge(std::uint32_t face, std::uint32_t other) const {
    if (face == other) return false;
    const auto& edges = face_to_edges_[face];
    return std::ranges::any_of(face_to_edges_[other],
                               [&](std::uint32_t edge) { return std::ranges::binary_search(edges, edge); });
  }

  const Mesh& mesh_;
  const ModelTopology& topology_;
  const SizeField& sizes_;
  const intersection::TriangleTree& tree_;
  std::vector<std::array<std::uint32_t, 2>> model_pieces_;  // of model edges, ascending, the lower end first
  std::vector<std::vector<std::uint32_t>> face_to_edges_;   // ascending
  std::vector<std::array<std::uint32_t, 2>> acute_pairs_;   // of model edges, ascending, the lower first
};

}  // namespace

std::vector<Misfit> find_misfits(const Mesh& surface, const ModelTopology& topology, const SizeField& sizes,
                                 const std::function<double(const Vec3&)>& floor,
                                 const intersection::TriangleTree& tree, const SharedWork& work,
                                 std::span<const std::uint8_t> tri_is_new) {
  const MisfitSearch search(surface, topology, sizes, tree);
  std::vector<double> fitting(surface.tri_to_vert.size(), HUGE_VAL);
  work.fill<double>(fitting, 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t)
      if (tri_is_new.empty() || tri_is_new[t] != 0)
        fitting[t] = search.fitting_size(static_cast<std::uint32_t>(t), floor);
  });
  std::vector<Misfit> misfits;
  for (std::size_t t = 0; t < fitting.size(); ++t)
    if (fitting[t] < HUGE_VAL) misfits.push_back({static_cast<std::uint32_t>(t), fitting[t]});
  return misfits;
}

}  // namespace tetloom
