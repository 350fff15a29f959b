#include "mesher/layers/crossings.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "mesher/intersection/self_intersection.hpp"

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
  bool has_changed(std::uint32_t wall) const {
    return std::ranges::any_of(layers_.walls.triangles[wall].curves,
                               [&](std::uint32_t c) { return layers_.changed[c] != 0; });
  }

  void add(const std::array<std::uint32_t, 3>& verts, ModelRegionId region, std::uint32_t wall, std::uint32_t side,
           bool is_new) {
    if (!region.valid()) return;
    triangles_.push_back(verts);
    groups_.push_back(region.value);
    walls_.push_back(wall);
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
      const std::uint32_t wall = surface.tri_to_wall[t];
      const std::uint32_t side = wall == kNone ? layers_.sides.side_of(surface.mesh.tri_to_entity[t]) : kNone;
      const bool is_new = wall != kNone ? has_changed(wall) : side != kNone && side_is_new[side];
      add(verts, regions.front, wall, side, is_new);
      if (regions.back != regions.front) add(verts, regions.back, wall, side, is_new);
      // A wall triangle of which all corners have layers has none in common with its top.
      if (wall != kNone) add(layers_.walls.triangles[wall].verts, regions.front, kNone, kNone, false);
    }
  }

  // On flat side faces layers lie in the plane of the rest, whose rim does not cross itself.
  void add_bands() {
    for (const WallRim& rim : layers_.walls.rims) {
      const std::uint32_t side = layers_.sides.side_of(rim.side_face);
      if (layers_.sides.sides()[side].shape.kind == SideKind::Flat) continue;
      const WallTriangle& wall = layers_.walls.triangles[rim.wall];
      const std::uint32_t c = wall.curves[rim.corner], d = wall.curves[(rim.corner + 1) % 3];
      const int most = std::max(layers_.counts.count(c), layers_.counts.count(d));
      const bool is_new = has_changed(rim.wall);
      for (int level = 0; level < most; ++level) {
        const auto from = [&](std::uint32_t curve, int l) {
          return point(curve, std::min(l, layers_.counts.count(curve)));
        };
        const std::array quad{from(c, level), from(d, level), from(d, level + 1), from(c, level + 1)};
        // Diagonals as those of layers that are split into tets.
        const bool from_first = c < d;
        for (const auto& [i, j, k] : from_first ? std::array<std::array<std::size_t, 3>, 2>{{{0, 1, 2}, {0, 2, 3}}}
                                                : std::array<std::array<std::size_t, 3>, 2>{{{0, 1, 3}, {1, 2, 3}}})
          if (quad[i] != quad[j] && quad[j] != quad[k] && quad[k] != quad[i])
            add({quad[i], quad[j], quad[k]}, ModelRegionId(wall.region), rim.wall, kNone, is_new);
      }
    }
  }

  std::uint32_t point(std::uint32_t curve, int level) {
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
      if (walls_[t] != kNone) add_curves(layers_.walls.triangles[walls_[t]].curves);
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
  std::vector<std::uint32_t> groups_, walls_, sides_;  // per triangle: region, wall triangle, side face
  std::vector<std::uint8_t> is_new_;
  std::vector<std::uint32_t> first_level_;  // per curve, the point of level 1
  std::vector<std::uint8_t> is_hit_;
};

}  // namespace

std::vector<std::uint8_t> find_curves_in_the_way(const LayersInQuestion& layers, const TaskRunner& runner) {
  return CrossingTest(layers).run(runner);
}

}  // namespace tetloom::layers
