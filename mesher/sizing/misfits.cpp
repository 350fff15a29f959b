#include "mesher/sizing/misfits.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

#include "core/base/lists.hpp"

namespace tetloom {
namespace {

using Triangle = std::array<std::uint32_t, 3>;
using FloorAt = std::function<SizeFloor(const Vec3&)>;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFlatAngle = 15 * kDegree;
// On faces with layers: a prism on a triangle with an angle of 20 degrees has a scaled Jacobian of at most .4. The
// second is tan 22 degrees and what edges of one size differ in length.
constexpr double kFlatAngleBelowLayers = 22 * kDegree, kLeastWidthBelowLayers = 0.55;
// Corners nearer than this, in sizes, may be what makes a place narrow.
constexpr double kNear = 2;
// What is narrower than this share of the size, so that tets have angles of 5 degrees, is refined beyond the usual
// floor up to the second share: 9 degrees.
constexpr double kSevere = 0.1, kEasedWidth = 0.2;
// A width that is less of the smallest size allowed would leave more poor elements than it found.
constexpr double kHopeless = 0.1;
// Cosines between a ray and what is called the opposite wall: from inside a triangle, from an edge, and of one that the
// triangle's face meets.
constexpr double kOpposite = 0.7, kBesideEdge = 0.35, kParallel = 0.9998;
// Cosine between model edges that narrow a face towards a corner.
constexpr double kAcute = 0.85;

bool share_a_vertex(const Triangle& s, const Triangle& t) {
  return std::ranges::any_of(s, [&](std::uint32_t v) { return std::ranges::find(t, v) != t.end(); });
}

class MisfitSearch {
 public:
  MisfitSearch(const Mesh& surface, const ModelTopology& topology, const SizeField& sizes,
               const intersection::TriangleTree& tree, std::span<const std::uint8_t> face_has_layers)
      : mesh_(surface), topology_(topology), sizes_(sizes), tree_(tree), face_has_layers_(face_has_layers) {
    sort_pieces();
    sum_normals();
    face_to_edges_.resize(topology.face_count());
    for (std::size_t f = 0; f < face_to_edges_.size(); ++f) {
      for (const ModelLoop& loop : topology.face_to_loops[f])
        for (const EdgeUse& use : loop) face_to_edges_[f].push_back(use.edge.value);
      std::ranges::sort(face_to_edges_[f]);
    }
    find_corners();
    find_acute_corners();
  }

  /// Puts the sizes that fit on the triangles of a leaf of the tree: where one is smaller than the present size; 0
  /// where no size allowed does; else infinity. Walls near all of them are looked for at once.
  void put_fitting_sizes(std::size_t leaf, std::span<const std::uint8_t> tri_is_new, const FloorAt& floor,
                         double* fitting) const {
    const std::span<const std::uint32_t> triangles = tree_.leaf_triangles(leaf);
    std::vector<PresentSize> present;
    Box3 box;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      fitting[i] = HUGE_VAL;
      if (!tri_is_new.empty() && tri_is_new[triangles[i]] == 0) continue;
      const auto [a, b, c] = tree_.corners_of(triangles[i]);
      const Vec3 center = (1.0 / 3) * (a + b + c);
      const double size = sizes_.size_at(center);
      present.push_back({i, center, size});
      const Box3 own = tree_.box_of(triangles[i]);
      const Vec3 reach = kLeastWidth * Vec3{size, size, size};
      box.add({own.lo - reach, own.hi + reach});
    }
    std::vector<std::size_t> leaves;
    if (!present.empty()) tree_.for_each_leaf_in(box, 0, [&](std::size_t near) { leaves.push_back(near); });
    for (const auto& [i, center, size] : present)
      fitting[i] = fitting_size({triangles[i], leaves}, center, size, floor);
  }

 private:
  /// A triangle and the leaves in which its walls are.
  struct Place {
    std::uint32_t triangle;
    std::span<const std::size_t> leaves;
  };
  /// The size at the i-th triangle of a leaf.
  struct PresentSize {
    std::size_t i;
    Vec3 center;
    double size;
  };

  /// Of one triangle; see put_fitting_sizes.
  double fitting_size(const Place& place, const Vec3& center, double present, const FloorAt& floor) const {
    const std::uint32_t triangle = place.triangle;
    const auto [a, b, c] = tree_.corners_of(triangle);
    const Vec3 normal = normalized(cross(b - a, c - a));
    if (norm2(normal) == 0) return HUGE_VAL;
    const double reach = kLeastWidth * present;
    const auto [usual, severe] = floor(center);
    double width = height_of_flat(triangle, {a, b, c}, kFlatAngle);
    double size_below_layers = HUGE_VAL;
    if (has_layers(triangle)) {
      const double height = height_of_flat(triangle, {a, b, c}, kFlatAngleBelowLayers);
      if (height >= kHopeless * severe) size_below_layers = std::max(height / kLeastWidthBelowLayers, severe);
    }
    double severe_width = is_near_acute_corner(triangle, center, present) ? HUGE_VAL : width;
    for (const Wall& wall : find_walls(place, center, reach * normal)) {
      if (wall.cosine <= kOpposite) continue;
      width = std::min(width, wall.distance);
      if (!meet_near(triangle, wall.triangle, center, present)) severe_width = std::min(severe_width, wall.distance);
    }
    const double edge_width = width_at_edges(place, normal, reach, present);
    if (edge_width < kSevere * present) severe_width = std::min(severe_width, edge_width);
    width = std::min({width, severe_width, edge_width});
    if (width == HUGE_VAL && size_below_layers == HUGE_VAL) return HUGE_VAL;
    if (severe_width < kHopeless * severe) return 0;
    double size = std::max(width / kLeastWidth, usual);
    if (severe_width < kSevere * present) size = std::min(size, std::max(severe_width / kEasedWidth, severe));
    size = std::min(size, size_below_layers);
    return width >= kHopeless * severe && size < kWorthwhileSize * present ? size : HUGE_VAL;
  }

  struct AcuteCorner {
    std::array<std::uint32_t, 2> edges;  // the lower first
    Vec3 place;
  };

  void sort_pieces() {
    std::vector<std::uint32_t> order(mesh_.edge_to_vert.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto ends = [&](std::uint32_t i) {
      const auto& [a, b] = mesh_.edge_to_vert[i];
      return std::array{std::min(a, b), std::max(a, b)};
    };
    std::ranges::stable_sort(order, {}, ends);
    for (const std::uint32_t i : order) {
      model_pieces_.push_back(ends(i));
      piece_edges_.push_back(mesh_.edge_to_entity[i]);
    }
  }

  /// Of the triangles at each piece of a model edge: inwards and outwards between two faces of a region.
  void sum_normals() {
    piece_normals_.resize(model_pieces_.size());
    for (const Triangle& verts : mesh_.tri_to_vert) {
      const auto& [a, b, c] = verts;
      const Vec3 normal = normalized(cross(mesh_.points[b] - mesh_.points[a], mesh_.points[c] - mesh_.points[a]));
      for (std::size_t i = 0; i < 3; ++i)
        if (const std::size_t piece = find_piece(verts[i], verts[(i + 1) % 3]); piece < model_pieces_.size())
          piece_normals_[piece] += normal;
    }
  }

  /// How wide a wall is at the sides of the triangle that are pieces of model edges, along its normal and between it
  /// and its neighbours': it may be very narrow at an edge alone, which points at another side.
  double width_at_edges(const Place& place, const Vec3& normal, double reach, double present) const {
    double width = HUGE_VAL;
    const Triangle& verts = mesh_.tri_to_vert[place.triangle];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t v = verts[i], w = verts[(i + 1) % 3];
      const std::size_t piece = find_piece(v, w);
      if (piece == model_pieces_.size()) continue;
      const Vec3 middle = 0.5 * (mesh_.points[v] + mesh_.points[w]);
      for (const Vec3& along : {normal, normalized(piece_normals_[piece])})
        for (const Wall& wall : find_walls(place, middle, reach * along))
          if (wall.cosine > kBesideEdge && !meet_near(place.triangle, wall.triangle, middle, present))
            width = std::min(width, wall.cosine * wall.distance);
    }
    return width;
  }

  /// Whether a point is an end of the model edge, and not one that was merged with it.
  bool ends_at(std::uint32_t edge, std::uint32_t v) const {
    const ModelEntity at = mesh_.point_to_entity[v];
    return at.dim == 0 && std::ranges::any_of(topology_.edges[edge].vertices,
                                              [&](ModelVertexId vertex) { return vertex.value == at.index; });
  }

  /// Pairs of model edges that meet at less than kAcute, as the mesh has them. The ends of a narrow face of which only
  /// these were eliminated are none: smaller sizes do make them better.
  void find_acute_corners() {
    struct End {
      std::uint32_t corner, edge;
      Vec3 direction;
    };
    std::vector<End> ends;
    for (std::size_t i = 0; i < mesh_.edge_to_vert.size(); ++i) {
      const auto [a, b] = mesh_.edge_to_vert[i];
      const Vec3 along = normalized(mesh_.points[b] - mesh_.points[a]);
      if (ends_at(mesh_.edge_to_entity[i], a)) ends.push_back({a, mesh_.edge_to_entity[i], along});
      if (ends_at(mesh_.edge_to_entity[i], b)) ends.push_back({b, mesh_.edge_to_entity[i], -along});
    }
    std::ranges::stable_sort(ends, {}, &End::corner);
    for (std::size_t i = 0; i < ends.size(); ++i)
      for (std::size_t j = i + 1; j < ends.size() && ends[j].corner == ends[i].corner; ++j)
        if (ends[i].edge != ends[j].edge && dot(ends[i].direction, ends[j].direction) > kAcute)
          acute_corners_.push_back({{std::min(ends[i].edge, ends[j].edge), std::max(ends[i].edge, ends[j].edge)},
                                    mesh_.points[ends[i].corner]});
    std::ranges::stable_sort(acute_corners_, {}, &AcuteCorner::edges);
  }

  /// Whether all corners of the triangle lie on two edges of its face that meet at a small angle.
  bool lies_in_acute_corner(std::uint32_t triangle) const {
    const auto& edges = face_to_edges_[mesh_.tri_to_entity[triangle]];
    const auto lies_on = [&](std::uint32_t v, std::uint32_t edge) {
      const ModelEntity at = mesh_.point_to_entity[v];
      return at.dim == 1 ? at.index == edge : ends_at(edge, v);
    };
    const auto holds = [&](const AcuteCorner& corner) {
      return std::ranges::binary_search(edges, corner.edges[1]) &&
             std::ranges::all_of(mesh_.tri_to_vert[triangle], [&](std::uint32_t v) {
               return lies_on(v, corner.edges[0]) || lies_on(v, corner.edges[1]);
             });
    };
    for (const std::uint32_t edge : edges) {
      const auto first =
          std::ranges::lower_bound(acute_corners_, std::array{edge, std::uint32_t{0}}, {}, &AcuteCorner::edges);
      for (auto corner = first; corner != acute_corners_.end() && corner->edges[0] == edge; ++corner)
        if (holds(*corner)) return true;
    }
    return false;
  }

  /// Whether two edges of the triangle's face meet at a small angle near a place: if that is a cusp, its angle becomes
  /// smaller, the finer it is meshed.
  bool is_near_acute_corner(std::uint32_t triangle, const Vec3& x, double present) const {
    const auto& edges = face_to_edges_[mesh_.tri_to_entity[triangle]];
    return std::ranges::any_of(edges, [&](std::uint32_t edge) {
      auto corner =
          std::ranges::lower_bound(acute_corners_, std::array{edge, std::uint32_t{0}}, {}, &AcuteCorner::edges);
      for (; corner != acute_corners_.end() && corner->edges[0] == edge; ++corner)
        if (distance(corner->place, x) < kNear * present && std::ranges::binary_search(edges, corner->edges[1]))
          return true;
      return false;
    });
  }

  bool has_layers(std::uint32_t triangle) const {
    return !face_has_layers_.empty() && face_has_layers_[mesh_.tri_to_entity[triangle]] != 0;
  }

  /// The least height of a triangle with an angle below `least` that is not the model's; else infinity.
  double height_of_flat(std::uint32_t triangle, const std::array<Vec3, 3>& x, double least) const {
    std::array<double, 3> length2{};  // of the edge opposite to each corner
    for (std::size_t i = 0; i < 3; ++i) length2[i] = norm2(x[(i + 2) % 3] - x[(i + 1) % 3]);
    const std::size_t i = std::ranges::min_element(length2) - length2.begin();
    const Vec3 u = x[(i + 1) % 3] - x[i], v = x[(i + 2) % 3] - x[i];
    const double twice_area = norm(cross(u, v));
    if (std::atan2(twice_area, dot(u, v)) >= least) return HUGE_VAL;
    const Triangle& verts = mesh_.tri_to_vert[triangle];
    if (lies_on_piece(verts[i], verts[(i + 1) % 3]) && lies_on_piece(verts[i], verts[(i + 2) % 3])) return HUGE_VAL;
    if (lies_in_acute_corner(triangle)) return HUGE_VAL;
    return twice_area / std::sqrt(std::ranges::max(length2));
  }

  /// Whether there is a piece of a model edge from a to b, and a lies on that edge: not where it was merged with it.
  bool lies_on_piece(std::uint32_t a, std::uint32_t b) const {
    const std::size_t piece = find_piece(a, b);
    if (piece == model_pieces_.size()) return false;
    const ModelEntity at = mesh_.point_to_entity[a];
    return at.dim == 1 ? at.index == piece_edges_[piece] : ends_at(piece_edges_[piece], a);
  }

  /// The number of a piece of a model edge; that of all pieces where the edge is none.
  std::size_t find_piece(std::uint32_t a, std::uint32_t b) const {
    if (mesh_.point_to_entity[a].dim > 1 || mesh_.point_to_entity[b].dim > 1) return model_pieces_.size();
    const std::array<std::uint32_t, 2> key{std::min(a, b), std::max(a, b)};
    const auto at = std::ranges::lower_bound(model_pieces_, key);
    return at != model_pieces_.end() && *at == key ? at - model_pieces_.begin() : model_pieces_.size();
  }

  struct Wall {
    double distance = HUGE_VAL;
    double cosine = 0;  // between the ray and the wall's normal; 0: it is no wall for this triangle
    std::uint32_t triangle = 0;
  };

  /// Those on both sides of the triangle, as far as there are regions.
  std::array<Wall, 2> find_walls(const Place& place, const Vec3& x, const Vec3& ray) const {
    const FaceSides& sides = topology_.face_to_sides[mesh_.tri_to_entity[place.triangle]];
    return {sides.front.valid() ? find_wall(sides.front, place, x, ray) : Wall{},
            sides.back.valid() ? find_wall(sides.back, place, x, -ray) : Wall{}};
  }

  /// The first wall of the region within `ray` from `x`, on a triangle. Walls of others do not count: solids may touch.
  Wall find_wall(ModelRegionId region, const Place& place, const Vec3& x, const Vec3& ray) const {
    double nearest = 1;
    Wall wall;
    const Triangle& own = mesh_.tri_to_vert[place.triangle];
    tree_.for_each_along(x, ray, place.leaves, [&](std::uint32_t other) {
      if (other == place.triangle || share_a_vertex(own, mesh_.tri_to_vert[other])) return;
      const double at = crossing(other, x, ray);
      // Of triangles at the same distance any may come first: they share the edge or vertex that is hit.
      if (at >= nearest || near_region(other, ray) != region) return;
      nearest = at;
      wall = {at * norm(ray), cosine_to(place.triangle, other, ray), other};
    });
    return wall.cosine > 0 ? wall : Wall{};
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

  double cosine_to(std::uint32_t triangle, std::uint32_t other, const Vec3& ray) const {
    const auto [a, b, c] = tree_.corners_of(other);
    const double facing = std::abs(dot(normalized(cross(b - a, c - a)), normalized(ray)));
    const bool meet = meet_at_an_edge(mesh_.tri_to_entity[triangle], mesh_.tri_to_entity[other]);
    return meet && facing <= kParallel ? 0 : facing;
  }

  bool meet_at_an_edge(std::uint32_t face, std::uint32_t other) const {
    if (face == other) return false;
    const auto& edges = face_to_edges_[face];
    return std::ranges::any_of(face_to_edges_[other],
                               [&](std::uint32_t edge) { return std::ranges::binary_search(edges, edge); });
  }

  /// Vertices of each face, and where they are in the mesh.
  void find_corners() {
    face_to_corners_.resize(topology_.face_count());
    for (std::size_t f = 0; f < face_to_corners_.size(); ++f) {
      for (const std::uint32_t edge : face_to_edges_[f])
        for (const ModelVertexId vertex : topology_.edges[edge].vertices) face_to_corners_[f].push_back(vertex.value);
      std::ranges::sort(face_to_corners_[f]);
    }
    corner_places_.assign(topology_.vertex_count, std::nullopt);
    for (std::size_t v = 0; v < mesh_.points.size(); ++v)
      if (const ModelEntity at = mesh_.point_to_entity[v]; at.dim == 0) corner_places_[at.index] = mesh_.points[v];
  }

  /// Whether the faces of two triangles have a common vertex near a place, as walls have that close up to a cusp: the
  /// finer that is meshed, the smaller is its angle.
  bool meet_near(std::uint32_t triangle, std::uint32_t other, const Vec3& x, double present) const {
    const auto& corners = face_to_corners_[mesh_.tri_to_entity[other]];
    return std::ranges::any_of(face_to_corners_[mesh_.tri_to_entity[triangle]], [&](std::uint32_t corner) {
      const std::optional<Vec3>& place = corner_places_[corner];
      return place && distance(*place, x) < kNear * present && std::ranges::binary_search(corners, corner);
    });
  }

  const Mesh& mesh_;
  const ModelTopology& topology_;
  const SizeField& sizes_;
  const intersection::TriangleTree& tree_;
  std::span<const std::uint8_t> face_has_layers_;            // empty: none has
  std::vector<std::array<std::uint32_t, 2>> model_pieces_;   // of model edges, ascending, the lower end first
  std::vector<std::uint32_t> piece_edges_;                   // the edge of each
  std::vector<Vec3> piece_normals_;                          // of their triangles, summed
  std::vector<std::vector<std::uint32_t>> face_to_edges_;    // ascending
  std::vector<std::vector<std::uint32_t>> face_to_corners_;  // model vertices, ascending
  std::vector<std::optional<Vec3>> corner_places_;           // none for those that the mesh has no point at
  std::vector<AcuteCorner> acute_corners_;                   // ascending by edges
};

}  // namespace

std::vector<Misfit> find_misfits(const Mesh& surface, const ModelTopology& topology, const SizeField& sizes,
                                 const std::function<SizeFloor(const Vec3&)>& floor,
                                 const intersection::TriangleTree& tree, const SharedWork& work,
                                 std::span<const std::uint8_t> tri_is_new,
                                 std::span<const std::uint8_t> face_has_layers) {
  const MisfitSearch search(surface, topology, sizes, tree, face_has_layers);
  constexpr std::size_t kLeaf = intersection::TriangleTree::kLeafSize;
  constexpr std::size_t kLeavesPerBlock = 256;
  const std::vector<double> blocks((tree.leaf_count() + kLeavesPerBlock - 1) / kLeavesPerBlock, 1.0);
  std::vector<Misfit> misfits = joined(work.make_lists<Misfit>(blocks, [&](std::size_t block) {
    std::vector<Misfit> found;
    std::array<double, kLeaf> fitting;
    const std::size_t end = std::min(tree.leaf_count(), (block + 1) * kLeavesPerBlock);
    for (std::size_t leaf = block * kLeavesPerBlock; leaf < end; ++leaf) {
      search.put_fitting_sizes(leaf, tri_is_new, floor, fitting.data());
      const auto triangles = tree.leaf_triangles(leaf);
      for (std::size_t i = 0; i < triangles.size(); ++i)
        if (fitting[i] < HUGE_VAL) found.push_back({triangles[i], fitting[i]});
    }
    return found;
  }));
  std::ranges::sort(misfits, {}, &Misfit::triangle);
  return misfits;
}

bool are_negligible(const std::vector<Misfit>& misfits, const Mesh& surface, const SizeField& sizes,
                    std::size_t before) {
  constexpr double kFew = 1e-3;  // of the triangles
  if (static_cast<double>(misfits.size()) >= kFew * static_cast<double>(surface.tri_to_vert.size())) return false;
  if (misfits.size() >= before) return true;
  const std::vector<Vec3>& x = surface.points;
  return std::ranges::none_of(misfits, [&](const Misfit& misfit) {
    const auto& [a, b, c] = surface.tri_to_vert[misfit.triangle];
    return misfit.size <= kSevere / kEasedWidth * sizes.size_at((1.0 / 3) * (x[a] + x[b] + x[c]));
  });
}

}  // namespace tetloom
