#include "mesher/layers/walls.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include "core/base/disjoint_sets.hpp"
#include "mesher/layers/fan_plan.hpp"

namespace tetloom::layers {
namespace {

constexpr int kMostLayers = 1000;
constexpr double kLastLayer = 0.8;  // of the size, where no number of layers was asked for

// A triangle at an edge, whose lower end comes first where `forward`.
struct EdgeUser {
  std::uint32_t low, high, triangle;
  std::uint8_t corner;  // where the edge starts in the triangle
  bool forward;
};

// One side of a triangle at an edge.
struct SideUse {
  std::uint32_t triangle;
  std::uint8_t corner;
  bool is_front;
};

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

class WallFinder {
 public:
  WallFinder(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const LayerOptions& options,
             std::span<const std::uint32_t> blunt_verts)
      : mesh_(mesh),
        face_to_sides_(face_to_sides),
        fan_turn_(options.fan_angle > 0 ? radians(options.fan_angle) : HUGE_VAL),
        blunt_verts_(blunt_verts),
        asked_(face_to_sides.size(), nullptr) {
    for (const WallLayers& wall : options.walls)
      if (wall.face.value < asked_.size()) asked_[wall.face.value] = &wall;
  }

  Walls run() {
    find_triangles();
    across_.assign(3 * walls_.triangles.size(), kNone);
    link_edges();
    const FanPlan fans({mesh_.points, walls_.triangles, across_}, fan_turn_, blunt_verts_);
    join_corners(fans);
    number_curves();
    fans.add_to(walls_);
    list_triangles();
    find_widths();
    find_heights();
    return std::move(walls_);
  }

 private:
  ModelRegionId region_of(std::uint32_t triangle, bool is_front) const {
    const FaceSides& sides = face_to_sides_[mesh_.tri_to_entity[triangle]];
    return is_front ? sides.front : sides.back;
  }

  void find_triangles() {
    side_to_wall_.assign(2 * mesh_.tri_to_vert.size(), kNone);
    for (std::uint32_t t = 0; t < mesh_.tri_to_vert.size(); ++t) {
      const WallLayers* asked = asked_[mesh_.tri_to_entity[t]];
      for (const bool is_front : {true, false}) {
        if (!asked || !(is_front ? asked->in_front : asked->behind)) continue;
        const ModelRegionId region = region_of(t, is_front);
        if (!region.valid()) continue;
        auto verts = mesh_.tri_to_vert[t];
        if (!is_front) std::swap(verts[1], verts[2]);
        side_to_wall_[2 * t + is_front] = static_cast<std::uint32_t>(walls_.triangles.size());
        walls_.triangles.push_back({t, region.value, is_front, verts, {}});
      }
    }
  }

  std::uint32_t wall_of(const SideUse& use) const { return side_to_wall_[2 * use.triangle + use.is_front]; }

  // All triangles at all edges that a wall triangle has, edge by edge.
  std::vector<EdgeUser> edge_users() const {
    std::vector<std::uint8_t> is_at_wall(mesh_.points.size(), 0);
    for (const WallTriangle& wall : walls_.triangles)
      for (const std::uint32_t v : wall.verts) is_at_wall[v] = 1;
    std::vector<EdgeUser> users;
    for (std::uint32_t t = 0; t < mesh_.tri_to_vert.size(); ++t)
      for (std::uint8_t i = 0; i < 3; ++i) {
        const std::uint32_t a = mesh_.tri_to_vert[t][i], b = mesh_.tri_to_vert[t][(i + 1) % 3];
        if (is_at_wall[a] && is_at_wall[b]) users.push_back({std::min(a, b), std::max(a, b), t, i, a < b});
      }
    std::ranges::sort(users, [](const EdgeUser& x, const EdgeUser& y) {
      return std::tie(x.low, x.high, x.triangle, x.corner) < std::tie(y.low, y.high, y.triangle, y.corner);
    });
    return users;
  }

  void link_edges() {
    const std::vector<EdgeUser> users = edge_users();
    for (std::size_t begin = 0; begin < users.size();) {
      std::size_t end = begin;
      while (end < users.size() && users[end].low == users[begin].low && users[end].high == users[begin].high) ++end;
      link_at_edge(
          {users.begin() + static_cast<std::ptrdiff_t>(begin), users.begin() + static_cast<std::ptrdiff_t>(end)});
      begin = end;
    }
  }

  // Around an edge, the side of a triangle that looks towards greater angles faces that of the next one that looks
  // towards smaller ones.
  void link_at_edge(std::vector<EdgeUser> users) {
    if (users.size() > 2) sort_around(users);
    for (std::size_t i = 0; i < users.size(); ++i) {
      const EdgeUser &here = users[i], &next = users[(i + 1) % users.size()];
      link({here.triangle, here.corner, here.forward}, {next.triangle, next.corner, !next.forward});
    }
  }

  void sort_around(std::vector<EdgeUser>& users) const {
    const Vec3 &from = mesh_.points[users[0].low], &to = mesh_.points[users[0].high];
    const Vec3 along = normalized(to - from);
    const auto across = [&](const EdgeUser& user) {
      const Vec3 d = mesh_.points[mesh_.tri_to_vert[user.triangle][(user.corner + 2) % 3]] - from;
      return d - dot(d, along) * along;
    };
    const Vec3 first = normalized(across(users[0])), second = cross(along, first);
    std::vector<std::pair<double, EdgeUser>> angles;
    for (const EdgeUser& user : users) {
      const Vec3 d = across(user);
      angles.push_back({std::atan2(dot(d, second), dot(d, first)), user});
    }
    std::ranges::stable_sort(angles, {}, [](const auto& angle) { return angle.first; });
    for (std::size_t i = 0; i < users.size(); ++i) users[i] = angles[i].second;
  }

  void link(const SideUse& one, const SideUse& other) {
    const ModelRegionId region = region_of(one.triangle, one.is_front);
    if (!region.valid()) return;
    const std::uint32_t wall = wall_of(one), other_wall = wall_of(other);
    if (wall != kNone && other_wall != kNone && region == region_of(other.triangle, other.is_front)) {
      const std::uint32_t edge = edge_of(wall, one), other_edge = edge_of(other_wall, other);
      across_[edge] = other_edge, across_[other_edge] = edge;
      return;
    }
    if (wall != kNone) add_rim(wall, one, other.triangle);
    if (other_wall != kNone) add_rim(other_wall, other, one.triangle);
  }

  // The corner of the wall triangle at which the edge starts, seen from its region.
  std::uint32_t edge_of(std::uint32_t wall, const SideUse& use) const {
    const auto& verts = walls_.triangles[wall].verts;
    const std::uint32_t start = mesh_.tri_to_vert[use.triangle][(use.corner + (use.is_front ? 0 : 1)) % 3];
    return 3 * wall + static_cast<std::uint32_t>(std::ranges::find(verts, start) - verts.begin());
  }

  void join_corners(const FanPlan& fans) {
    corner_sets_ = DisjointSets(across_.size());
    for (std::uint32_t e = 0; e < across_.size(); ++e)
      if (across_[e] != kNone && !fans.parts_at_start(e)) corner_sets_.join(e, next_corner(across_[e]));
  }

  void add_rim(std::uint32_t wall, const SideUse& use, std::uint32_t side_triangle) {
    walls_.rims.push_back({wall, edge_of(wall, use) - 3 * wall, mesh_.tri_to_entity[side_triangle], side_triangle});
  }

  void number_curves() {
    std::vector<std::uint32_t> set_to_curve(3 * walls_.triangles.size(), kNone);
    for (std::uint32_t i = 0; i < set_to_curve.size(); ++i) {
      std::uint32_t& curve = set_to_curve[corner_sets_.find(i)];
      if (curve == kNone) {
        curve = static_cast<std::uint32_t>(walls_.curve_to_vert.size());
        walls_.curve_to_vert.push_back(walls_.triangles[i / 3].verts[i % 3]);
      }
      walls_.triangles[i / 3].curves[i % 3] = curve;
    }
  }

  void list_triangles() {
    walls_.curve_begin.assign(walls_.curve_count() + 1, 0);
    for (const WallTriangle& wall : walls_.triangles)
      for (const std::uint32_t c : wall.curves) ++walls_.curve_begin[c + 1];
    for (std::size_t c = 0; c < walls_.curve_count(); ++c) walls_.curve_begin[c + 1] += walls_.curve_begin[c];
    std::vector<std::uint32_t> next(walls_.curve_begin.begin(), walls_.curve_begin.end() - 1);
    walls_.curve_triangles.resize(3 * walls_.triangles.size());
    for (std::uint32_t w = 0; w < walls_.triangles.size(); ++w)
      for (const std::uint32_t c : walls_.triangles[w].curves) walls_.curve_triangles[next[c]++] = w;
  }

  void find_widths() {
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      const std::span<const std::uint32_t> triangles = walls_.triangles_at(c);
      const Vec3& foot = mesh_.points[walls_.curve_to_vert[c]];
      double lengths = 0;
      for (const std::uint32_t w : triangles)
        for (const std::uint32_t v : walls_.triangles[w].verts) lengths += distance(foot, mesh_.points[v]);
      walls_.curve_to_width.push_back(lengths / std::max<double>(1, 2 * static_cast<double>(triangles.size())));
      walls_.curve_to_region.push_back(triangles.empty() ? kNone : walls_.triangles[triangles[0]].region);
    }
    // Curves without triangles come behind the others of their fan.
    for (const FanVertex& fan : walls_.fan_vertices)
      for (const std::uint32_t c : fan.curves)
        if (walls_.triangles_at(c).empty()) {
          walls_.curve_to_width[c] = walls_.curve_to_width[fan.curves[0]];
          walls_.curve_to_region[c] = walls_.curve_to_region[fan.curves[0]];
        }
  }

  void find_heights() {
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      LayerHeights& finest = walls_.curve_to_heights.emplace_back();
      for (const std::uint32_t w : walls_.triangles_at(c))
        take_finer(finest, asked_heights(walls_.triangles[w], walls_.curve_to_width[c]));
    }
    for (const FanVertex& fan : walls_.fan_vertices) {
      LayerHeights finest;
      for (const std::uint32_t c : fan.curves) take_finer(finest, walls_.curve_to_heights[c]);
      for (const std::uint32_t c : fan.curves) walls_.curve_to_heights[c] = finest;
    }
  }

  static void take_finer(LayerHeights& finest, const LayerHeights& heights) {
    if (heights.count == 0) return;
    const int count = finest.count > 0 ? std::min(finest.count, heights.count) : heights.count;
    if (finest.count == 0 || heights.first < finest.first) finest = heights;
    finest.count = count;
  }

  LayerHeights asked_heights(const WallTriangle& wall, double width) const {
    const WallLayers& asked = *asked_[mesh_.tri_to_entity[wall.triangle]];
    LayerHeights heights{asked.first_height, asked.growth, asked.count};
    if (asked.count == 0) {
      heights.count = 1;
      while (heights.count < kMostLayers && heights.last(heights.count) < kLastLayer * width) ++heights.count;
      if (heights.count > 1 && heights.last(heights.count) > width) --heights.count;
    }
    if (asked.thickness > 0)
      while (heights.count > 1 && heights.sum(heights.count) > asked.thickness) --heights.count;
    return heights;
  }

  const Mesh& mesh_;
  std::span<const FaceSides> face_to_sides_;
  double fan_turn_;  // radians
  std::span<const std::uint32_t> blunt_verts_;
  std::vector<const WallLayers*> asked_;     // per model face
  std::vector<std::uint32_t> side_to_wall_;  // 2 · triangle + is_front
  std::vector<std::uint32_t> across_;        // per edge, 3 · wall + corner where it starts
  DisjointSets corner_sets_;                 // 3 · wall + corner
  Walls walls_;
};

}  // namespace

double LayerHeights::sum(int layers) const {
  return growth == 1 ? first * layers : first * (std::pow(growth, layers) - 1) / (growth - 1);
}

double LayerHeights::last(int layers) const { return first * std::pow(growth, layers - 1); }

Walls find_walls(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const LayerOptions& options,
                 std::span<const std::uint32_t> blunt_verts) {
  return WallFinder(mesh, face_to_sides, options, blunt_verts).run();
}

}  // namespace tetloom::layers
