#include "mesher/layers/crossings.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "mesher/intersection/self_intersection.hpp"
#include "mesher/layers/stack_cells.hpp"

namespace tetloom::layers {
namespace {

constexpr std::size_t kMostCrossings = 1'000'000;

class CrossingTest {
 public:
  explicit CrossingTest(const LayersInQuestion& layers) : layers_(layers), points_(layers.surface.mesh.points) {}

  std::vector<std::uint8_t> run(const TaskRunner& runner) {
    add_surface();
    add_bands();
    const std::vector<TriangleIntersection> found =
        find_self_intersections({points_, triangles_, groups_, kMostCrossings, false, is_new_}, runner);
    is_hit_.assign(layers_.walls.curve_count(), 0);
    for (const TriangleIntersection& crossing : found) mark(crossing);
    return std::move(is_hit_);
  }

 private:
  bool has_changed(std::uint32_t stack) const {
    return std::ranges::any_of(layers_.walls.curves_of(stack),
                               [&](std::uint32_t c) { return layers_.changed[c] != 0; });
  }

  void add(const std::array<std::uint32_t, 3>& verts, ModelRegionId region, std::uint32_t stack, std::uint32_t side,
           bool is_new) {
    if (!region.valid()) return;
    triangles_.push_back(verts);
    groups_.push_back(region.value);
    stacks_.push_back(stack);
    sides_.push_back(side);
    is_new_.push_back(is_new);
  }

  void add_surface() {
    const LayeredSurface& surface = layers_.surface;
    std::vector<std::uint8_t> side_is_new;
    for (const SideFace& side : layers_.sides.sides())
      side_is_new.push_back(std::ranges::any_of(side.curves, [&](std::uint32_t c) { return layers_.changed[c] != 0; }));
    for (std::size_t t = 0; t < surface.is_top.size(); ++t) {
      const FaceSides& regions = surface.tri_to_sides[t];
      const auto& verts = surface.mesh.tri_to_vert[t];
      const std::uint32_t stack = surface.tri_to_stack[t];
      const std::uint32_t side = stack == kNone ? layers_.sides.side_of(surface.mesh.tri_to_entity[t]) : kNone;
      const bool is_new = stack != kNone ? has_changed(stack) : side != kNone && side_is_new[side];
      add(verts, regions.front, stack, side, is_new);
      if (regions.back != regions.front) add(verts, regions.back, stack, side, is_new);
      // A wall triangle of which all corners have layers has none in common with its top.
      if (stack != kNone && !layers_.walls.is_fan(stack))
        add(layers_.walls.triangles[stack].verts, regions.front, kNone, kNone, false);
    }
  }

  // On flat side faces layers lie in the plane of the rest, whose rim does not cross itself.
  void add_bands() {
    for (const WallRim& rim : layers_.walls.rims) {
      const std::uint32_t side = layers_.sides.side_of(rim.side_face);
      if (layers_.sides.sides()[side].shape.kind == SideKind::Flat) continue;
      const WallTriangle& wall = layers_.walls.triangles[rim.wall];
      const std::uint32_t c = wall.curves[rim.corner], d = wall.curves[(rim.corner + 1) % 3];
      const auto add_band = [&](const std::array<CurveLevel, 3>& at) {
        add({point(at[0]), point(at[1]), point(at[2])}, ModelRegionId(wall.region), rim.wall, kNone,
            has_changed(rim.wall));
      };
      for_each_between(layers_.walls, layers_.counts, {c, d}, [&](const auto& element) {
        if constexpr (std::tuple_size_v<std::decay_t<decltype(element)>> == 3) {
          add_band(element);
        } else {  // cut as where layers are split into tets
          const std::size_t start = comes_before(layers_.walls, element[0], element[1]) ? 0 : 1;
          add_band({element[start], element[start + 1], element[start + 2]});
          add_band({element[start], element[start + 2], element[(start + 3) % 4]});
        }
      });
    }
  }

  std::uint32_t point(const CurveLevel& at) {
    const auto [curve, level] = at;
    if (level == 0) return layers_.walls.curve_to_vert[curve];
    if (level == layers_.counts.count(curve)) return layers_.surface.curve_to_top[curve];
    if (first_level_.empty()) first_level_.assign(layers_.walls.curve_count(), kNone);
    std::uint32_t& first = first_level_[curve];
    if (first == kNone) {
      first = static_cast<std::uint32_t>(points_.size());
      for (int l = 1; l < layers_.counts.count(curve); ++l) points_.push_back(layers_.counts.point(curve, l));
    }
    return first + static_cast<std::uint32_t>(level) - 1;
  }

  // The layers that one of the triangles belongs to; of a side face that something else crosses, all on it. Low ones
  // beside thick ones are not what is in the way.
  void mark(const TriangleIntersection& crossing) {
    constexpr double kLow = 0.3;
    std::vector<std::uint32_t> curves;
    const auto add_curves = [&](std::span<const std::uint32_t> more) {
      std::ranges::copy_if(more, std::back_inserter(curves),
                           [&](std::uint32_t c) { return layers_.counts.count(c) > 0; });
    };
    for (const std::uint32_t t : {crossing.first, crossing.second})
      if (stacks_[t] != kNone) add_curves(layers_.walls.curves_of(stacks_[t]));
    for (const std::uint32_t t : {crossing.first, crossing.second})
      if (curves.empty() && sides_[t] != kNone) add_curves(layers_.sides.sides()[sides_[t]].curves);
    double thickest = 0;
    for (const std::uint32_t c : curves) thickest = std::max(thickest, layers_.counts.thickness(c));
    for (const std::uint32_t c : curves)
      if (layers_.counts.thickness(c) >= kLow * thickest) is_hit_[c] = 1;
  }

  const LayersInQuestion& layers_;
  std::vector<Vec3> points_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<std::uint32_t> groups_, stacks_, sides_;  // per triangle: region, stack, side face
  std::vector<std::uint8_t> is_new_;
  std::vector<std::uint32_t> first_level_;  // per curve, the point of level 1
  std::vector<std::uint8_t> is_hit_;
};

}  // namespace

std::vector<std::uint8_t> find_curves_in_the_way(const LayersInQuestion& layers, const TaskRunner& runner) {
  return CrossingTest(layers).run(runner);
}

}  // namespace tetloom::layers
