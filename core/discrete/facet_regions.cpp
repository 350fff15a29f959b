#include "core/discrete/facet_regions.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/disjoint_sets.hpp"
#include "core/discrete/facet_bvh.hpp"

namespace tetloom::detail {
namespace {

constexpr std::uint32_t front_side(std::uint32_t leaf) { return 2 * leaf; }
constexpr std::uint32_t back_side(std::uint32_t leaf) { return 2 * leaf + 1; }

/// Leaves joined into components and sides joined into shells; both are named by their lowest member.
struct Shells {
  std::vector<std::uint32_t> leaf_to_component, side_to_shell;
};

/// Joins the sides that face each other around one edge that is no joint.
class EdgeUmbrella {
 public:
  EdgeUmbrella(const FacetSurface& surface, std::uint32_t edge) : surface_(surface) {
    const auto [low, high] = surface.edges.edge_to_vert[edge];
    origin_ = surface.points[low], low_ = low;
    axis_ = normalized(surface.points[high] - origin_);
    for (const std::uint32_t half : surface.edges.halves(edge)) spokes_.push_back({0, half});
    set_angles();
    std::sort(spokes_.begin(), spokes_.end());
  }

  void join(DisjointSets& sides) const {
    for (std::size_t i = 0; i < spokes_.size(); ++i) {
      sides.join(side(spokes_[i], true), side(spokes_[(i + 1) % spokes_.size()], false));
    }
  }

 private:
  struct Spoke {
    double angle;
    std::uint32_t half;
    friend auto operator<=>(const Spoke&, const Spoke&) = default;
  };

  void set_angles() {
    Vec3 first, second;
    for (Spoke& spoke : spokes_) {
      Vec3 arm = surface_.points[surface_.origin(previous_half(spoke.half))] - origin_;
      arm -= dot(arm, axis_) * axis_;
      if (first == Vec3{}) first = normalized(arm), second = cross(axis_, first);
      const double angle = std::atan2(dot(arm, second), dot(arm, first));
      spoke.angle = angle < -1e-12 ? angle + 2 * M_PI : std::max(angle, 0.0);
    }
  }

  /// The side of a spoke's facet that looks at larger angles, or at smaller ones. A half-edge along the axis has its
  /// normal (axis × arm) towards larger angles.
  std::uint32_t side(const Spoke& spoke, bool towards_larger) const {
    const bool along = surface_.origin(spoke.half) == low_;
    const std::uint32_t leaf = surface_.tri_to_leaf[half_to_tri(spoke.half)];
    return along == towards_larger ? front_side(leaf) : back_side(leaf);
  }

  const FacetSurface& surface_;
  Vec3 origin_, axis_;
  std::uint32_t low_ = 0;
  std::vector<Spoke> spokes_;
};

Shells find_shells(const FacetSurface& surface) {
  DisjointSets leaves(surface.leaf_count), sides(2 * std::size_t{surface.leaf_count});
  for (std::uint32_t edge = 0; edge < surface.edges.size(); ++edge) {
    if (surface.edge_is_joint[edge]) continue;
    const auto halves = surface.edges.halves(edge);
    for (const std::uint32_t half : halves) {
      leaves.join(surface.tri_to_leaf[half_to_tri(halves[0])], surface.tri_to_leaf[half_to_tri(half)]);
    }
    EdgeUmbrella(surface, edge).join(sides);
  }
  Shells shells{std::vector<std::uint32_t>(surface.leaf_count), std::vector<std::uint32_t>(2 * surface.leaf_count)};
  for (std::uint32_t leaf = 0; leaf < surface.leaf_count; ++leaf) shells.leaf_to_component[leaf] = leaves.find(leaf);
  for (std::uint32_t side = 0; side < shells.side_to_shell.size(); ++side)
    shells.side_to_shell[side] = sides.find(side);
  return shells;
}

/// Per leaf: the volume between the leaf and the centre of the model, its first facet and its box.
struct LeafMeasures {
  std::vector<double> volume;
  std::vector<std::uint32_t> first_tri;
  std::vector<Box3> box;
};

LeafMeasures measure_leaves(const FacetSurface& surface) {
  const std::size_t count = surface.leaf_count;
  LeafMeasures measures{std::vector<double>(count, 0), std::vector<std::uint32_t>(count, kNone),
                        std::vector<Box3>(count)};
  const Box3 box = box_of(surface.points);
  const Vec3 center = box.center();
  for (std::uint32_t tri = 0; tri < surface.tri_to_vert.size(); ++tri) {
    const std::uint32_t leaf = surface.tri_to_leaf[tri];
    std::array<Vec3, 3> p;
    for (int i = 0; i < 3; ++i) {
      p[i] = surface.points[surface.tri_to_vert[tri][i]] - center;
      measures.box[leaf].add(surface.points[surface.tri_to_vert[tri][i]]);
    }
    measures.volume[leaf] += dot(p[0], cross(p[1], p[2])) / 6;
    measures.first_tri[leaf] = std::min(measures.first_tri[leaf], tri);
  }
  return measures;
}

/// The component's place among the others.
struct Component {
  std::uint32_t outer_shell = kNone;  ///< the shell seen from outside of the component
  std::uint32_t parent_cell = kNone;  ///< the shell of the cell that the component lies in
  std::uint32_t depth = 0;            ///< number of components around it
  double outer_volume = HUGE_VAL;
  Box3 box;
  std::uint32_t first_tri = kNone;
};

/// Everything about cells, indexed by component or by shell (entries of other indices are unused).
class CellFinder {
 public:
  explicit CellFinder(const FacetSurface& surface)
      : surface_(surface),
        shells_(find_shells(surface)),
        components_(surface.leaf_count),
        shell_volume_(2 * surface.leaf_count, 0) {
    measure();
    check_shells();
    nest();
  }

  FacetRegions regions() && {
    FacetRegions result;
    result.warnings = std::move(warnings_);
    std::vector<ModelRegionId> cell_to_region(shell_volume_.size());
    for (std::uint32_t side = 0; side < shell_volume_.size(); ++side) {
      const std::uint32_t shell = shells_.side_to_shell[side];
      if (holds_material(shell) && !cell_to_region[shell].valid()) {
        cell_to_region[shell] = ModelRegionId(result.region_count++);
      }
    }
    const auto region_at = [&](std::uint32_t side) {
      const std::uint32_t cell = cell_of(shells_.side_to_shell[side]);
      return cell == kNone ? ModelRegionId() : cell_to_region[cell];
    };
    for (std::uint32_t leaf = 0; leaf < surface_.leaf_count; ++leaf) {
      FaceSides sides{region_at(front_side(leaf)), region_at(back_side(leaf))};
      const bool turn = sides.front.valid() && !sides.back.valid();
      if (turn) std::swap(sides.front, sides.back);
      result.turn.push_back(turn);
      result.leaf_to_sides.push_back(sides);
    }
    return result;
  }

 private:
  std::uint32_t component_of_shell(std::uint32_t shell) const { return shells_.leaf_to_component[shell / 2]; }
  bool is_outer(std::uint32_t shell) const { return components_[component_of_shell(shell)].outer_shell == shell; }
  /// The cell that a shell bounds, named by the cell's own shell; kNone for the outside of everything.
  std::uint32_t cell_of(std::uint32_t shell) const {
    return is_outer(shell) ? components_[component_of_shell(shell)].parent_cell : shell;
  }
  double negligible_volume(const Component& component) const {
    const double diagonal = component.box.diagonal();
    return 1e-14 * diagonal * diagonal * diagonal;
  }
  bool holds_material(std::uint32_t shell) const {
    const Component& component = components_[component_of_shell(shell)];
    return !is_outer(shell) && component.depth % 2 == 0 && shell_volume_[shell] > negligible_volume(component);
  }

  void measure() {
    const LeafMeasures measures = measure_leaves(surface_);
    for (std::uint32_t leaf = 0; leaf < surface_.leaf_count; ++leaf) {
      shell_volume_[shells_.side_to_shell[front_side(leaf)]] -= measures.volume[leaf];
      shell_volume_[shells_.side_to_shell[back_side(leaf)]] += measures.volume[leaf];
      Component& component = components_[shells_.leaf_to_component[leaf]];
      component.box.add(measures.box[leaf]);
      component.first_tri = std::min(component.first_tri, measures.first_tri[leaf]);
    }
    for (std::uint32_t side = 0; side < shell_volume_.size(); ++side) {
      if (shells_.side_to_shell[side] != side) continue;
      Component& component = components_[component_of_shell(side)];
      if (!(shell_volume_[side] < component.outer_volume)) continue;
      component.outer_volume = shell_volume_[side], component.outer_shell = side;
    }
  }

  void check_shells() {
    for (std::uint32_t shell = 0; shell < shell_volume_.size(); ++shell) {
      if (shells_.side_to_shell[shell] != shell || is_outer(shell)) continue;
      const Component& component = components_[component_of_shell(shell)];
      const Vec3 point = surface_.points[surface_.tri_to_vert[component.first_tri][0]];
      if (shell_volume_[shell] < -1e-9 * std::abs(component.outer_volume) - negligible_volume(component)) {
        throw Error(Diagnostic{ErrorCode::InputUnsuitable,
                               "facets overlap where three or more of them share an edge, so that they bound no volume",
                               {},
                               point,
                               {}});
      }
      if (shell_volume_[shell] <= negligible_volume(component)) {
        warnings_.push_back(
            {ErrorCode::InputUnsuitable, "a closed surface encloses no volume and was left empty", {}, point, {}});
      }
    }
  }

  /// Finds for each component the cell around it, by the first facet that a ray from its extreme point meets. The
  /// component met reaches further in the ray's direction, so taking components from the far end knows its answer.
  void nest() {
    std::vector<std::uint32_t> list;
    for (std::uint32_t c = 0; c < components_.size(); ++c) {
      if (components_[c].outer_shell != kNone) list.push_back(c);
    }
    if (list.size() < 2) return;
    static constexpr std::array<Vec3, 5> kDirections{{{0.8017, 0.4513, 0.3921},
                                                      {-0.3319, 0.8127, 0.4789},
                                                      {0.4237, -0.3571, 0.8324},
                                                      {-0.6113, -0.5379, 0.5807},
                                                      {0.5531, -0.7019, -0.4487}}};
    const FacetBvh bvh(surface_.points, surface_.tri_to_vert);
    for (std::size_t i = 0; i < kDirections.size(); ++i) {
      const bool accept_any = i + 1 == kDirections.size();
      if (nest_along(normalized(kDirections[i]), bvh, list, accept_any)) return;
    }
  }

  bool nest_along(const Vec3& direction, const FacetBvh& bvh, std::vector<std::uint32_t> list, bool accept_any) {
    std::vector<std::uint32_t> extreme(components_.size(), kNone);
    std::vector<double> reach(components_.size(), -HUGE_VAL);
    for (std::uint32_t tri = 0; tri < surface_.tri_to_vert.size(); ++tri) {
      const std::uint32_t c = shells_.leaf_to_component[surface_.tri_to_leaf[tri]];
      for (const std::uint32_t v : surface_.tri_to_vert[tri]) {
        const double along = dot(direction, surface_.points[v]);
        if (along > reach[c]) reach[c] = along, extreme[c] = v;
      }
    }
    std::sort(list.begin(), list.end(),
              [&](std::uint32_t a, std::uint32_t b) { return reach[a] != reach[b] ? reach[a] > reach[b] : a < b; });
    for (const std::uint32_t c : list) {
      const auto hit = find_first_side(surface_.points[extreme[c]], direction, bvh, c);
      if (hit.doubtful && !accept_any) return false;
      components_[c].parent_cell = hit.side == kNone ? kNone : cell_of(shells_.side_to_shell[hit.side]);
      const std::uint32_t parent = components_[c].parent_cell;
      components_[c].depth = parent == kNone ? 0 : components_[component_of_shell(parent)].depth + 1;
    }
    return true;
  }

  struct Hit {
    std::uint32_t side = kNone;
    double t = HUGE_VAL;
    bool doubtful = false;  ///< the ray grazes a facet or passes within rounding of one's border
  };

  /// The first facet side of another component that a ray meets.
  Hit find_first_side(const Vec3& from, const Vec3& direction, const FacetBvh& bvh, std::uint32_t component) const {
    constexpr double kDoubt = 1e-9;
    Hit hit;
    const double start = 1e-12 * components_[component].box.diagonal();
    bvh.for_each_near_ray(from, direction, [&](std::uint32_t tri) {
      const std::uint32_t leaf = surface_.tri_to_leaf[tri];
      if (shells_.leaf_to_component[leaf] == component) return;
      const Triangle& v = surface_.tri_to_vert[tri];
      const Vec3 a = surface_.points[v[0]], ab = surface_.points[v[1]] - a, ac = surface_.points[v[2]] - a;
      const Vec3 normal = cross(ab, ac);
      const double steep = dot(normal, direction);
      if (std::abs(steep) <= kDoubt * norm(normal)) {
        // A ray within the plane of the facet: the facet counts only through its neighbours, unless it is near.
        if (std::abs(dot(from - a, normal)) <= start * norm(normal)) hit.doubtful = true;
        return;
      }
      const double t = dot(a - from, normal) / steep;
      const Vec3 along = cross(from - a, direction);
      const double b1 = -dot(ac, along) / steep, b2 = dot(ab, along) / steep;
      const double least = std::min({1 - b1 - b2, b1, b2});
      if (least < -kDoubt || t < -start) return;
      if (least < kDoubt || t < start) hit.doubtful = true;
      if (t < hit.t) hit.t = t, hit.side = steep < 0 ? front_side(leaf) : back_side(leaf);
    });
    return hit;
  }

  const FacetSurface& surface_;
  Shells shells_;
  std::vector<Component> components_;
  std::vector<double> shell_volume_;
  std::vector<Diagnostic> warnings_;
};

}  // namespace

FacetRegions find_regions(const FacetSurface& surface) { return CellFinder(surface).regions(); }

}  // namespace tetloom::detail
