#include "mesher/layers/wanted_heights.hpp"

#include <algorithm>

#include "core/base/grain.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/layers/clearance.hpp"

namespace tetloom::layers {
namespace {

constexpr double kOfGap = 0.35, kOfFreeGap = 0.7;  // that layers may take, with layers opposite and without
constexpr double kLeftInGap = 0.9;                 // widths that stay for other elements

class HeightSearch {
 public:
  HeightSearch(const CurveStarts& starts, const TaskRunner& runner)
      : starts_(starts), walls_(starts.walls), runner_(runner) {
    found_.heights.assign(walls_.curve_count(), 0);
    found_.limits.assign(walls_.curve_count(), LayerLimit::None);
  }

  WantedHeights run() {
    std::vector<double> reach(walls_.curve_count());
    for_each_curve([&](std::uint32_t c) {
      limit_layers(c);
      const double length = found_.heights[c] * starts_.stretch[c];
      reach[c] = std::max(length / kOfGap, 2 * length + kLeftInGap * walls_.curve_to_width[c]);
      if (const CurveSides* sides = starts_.sides.at(c)) shorten(c, sides->room, LayerLimit::SideAngle);
    });
    const std::vector<Clearance> clearances = find_clearances(reach);
    for_each_curve([&](std::uint32_t c) { shorten(c, length_in_gap(c, clearances[c]), LayerLimit::Gap); });
    return std::move(found_);
  }

 private:
  // Those that can grow.
  template <class Body>
  void for_each_curve(const Body& body) const {
    runner_.for_blocks(walls_.curve_count(), kStarGrain, [&](std::size_t begin, std::size_t end) {
      for (auto c = static_cast<std::uint32_t>(begin); c < end; ++c)
        if (starts_.directions[c] != Vec3{}) body(c);
    });
  }

  void limit_layers(std::uint32_t curve) {
    const LayerHeights& heights = walls_.curve_to_heights[curve];
    int count = heights.count;
    while (count > 1 && heights.last(count) > walls_.curve_to_width[curve]) --count;
    found_.heights[curve] = heights.sum(count);
    if (count < heights.count) found_.limits[curve] = LayerLimit::Isotropy;
  }

  std::vector<Clearance> find_clearances(const std::vector<double>& reach) const {
    const Mesh& mesh = starts_.mesh;
    std::vector<FaceSides> sides;
    for (const std::uint32_t face : mesh.tri_to_entity) sides.push_back(starts_.face_to_sides[face]);
    std::vector<std::uint8_t> has_layers(2 * mesh.tri_to_vert.size(), 0);
    for (const WallTriangle& wall : walls_.triangles) has_layers[2 * wall.triangle + wall.is_front] = 1;
    std::vector<LookAhead> looks;
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      looks.push_back(
          {walls_.curve_to_region[c], mesh.points[walls_.curve_to_vert[c]], starts_.directions[c], reach[c]});
    }
    const intersection::TriangleTree tree(mesh.points, mesh.tri_to_vert, runner_);
    const auto has_foot = [&](std::size_t curve, std::uint32_t triangle) {
      return std::ranges::count(mesh.tri_to_vert[triangle], walls_.curve_to_vert[curve]) > 0;
    };
    return layers::find_clearances({sides, has_layers, tree, has_foot}, looks, runner_);
  }

  // What leaves room for other elements, but one layer where it takes no more than its share.
  double length_in_gap(std::uint32_t curve, const Clearance& clearance) const {
    const double share = (clearance.has_layers ? kOfGap : kOfFreeGap) * clearance.distance;
    const double left = clearance.distance - kLeftInGap * walls_.curve_to_width[curve];
    const double one = walls_.curve_to_heights[curve].first * starts_.stretch[curve];
    return std::max(std::min(share, clearance.has_layers ? left / 2 : left), one <= share ? one : 0);
  }

  void shorten(std::uint32_t curve, double length, LayerLimit limit) {
    if (length >= found_.heights[curve] * starts_.stretch[curve]) return;
    found_.heights[curve] = length / starts_.stretch[curve];
    found_.limits[curve] = limit;
  }

  const CurveStarts& starts_;
  const Walls& walls_;
  const TaskRunner& runner_;
  WantedHeights found_;
};

}  // namespace

WantedHeights find_wanted_heights(const CurveStarts& starts, const TaskRunner& runner) {
  return HeightSearch(starts, runner).run();
}

}  // namespace tetloom::layers
