#include "mesher/layers/room_above.hpp"

#include <algorithm>

#include "core/base/grain.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/layers/clearance.hpp"
#include "mesher/layers/growth_direction.hpp"

namespace tetloom::layers {
namespace {

constexpr double kRoom = 0.5;  // of the width of the front

class RoomSearch {
 public:
  RoomSearch(const Walls& walls, const LayerCounts& counts, const LayeredSurface& surface, const TaskRunner& runner)
      : walls_(walls), counts_(counts), surface_(surface), runner_(runner), looks_(walls.curve_count()) {}

  std::vector<double> run(std::span<const std::uint8_t> asked) {
    runner_.for_blocks(looks_.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
      for (auto c = static_cast<std::uint32_t>(begin); c < end; ++c)
        if (asked[c] && counts_.count(c) > 1 && !walls_.triangles_at(c).empty()) looks_[c] = look_from(c);
    });
    std::vector<std::uint8_t> has_layers(2 * surface_.is_top.size(), 0);
    for (std::size_t t = 0; t < surface_.is_top.size(); ++t) has_layers[2 * t + 1] = surface_.is_top[t];
    const Mesh& mesh = surface_.mesh;
    const intersection::TriangleTree tree(mesh.points, mesh.tri_to_vert, runner_);
    const std::vector<Clearance> clearances =
        find_clearances({surface_.tri_to_sides, has_layers, tree,
                         [&](std::size_t curve, std::uint32_t triangle) { return is_beside(curve, triangle); }},
                        looks_, runner_);
    std::vector<double> lacking(looks_.size(), 0);
    for (std::size_t c = 0; c < lacking.size(); ++c) {
      const double lack = std::max(0.0, looks_[c].reach - clearances[c].distance);
      lacking[c] = clearances[c].has_layers ? lack / 2 : lack;
    }
    return lacking;
  }

 private:
  LookAhead look_from(std::uint32_t curve) const {
    thread_local std::vector<Vec3> normals;
    normals.clear();
    double lengths = 0;
    const Vec3 top = counts_.top(curve);
    for (const std::uint32_t w : walls_.triangles_at(curve)) {
      const auto& [a, b, c] = walls_.triangles[w].curves;
      const Vec3 &x = counts_.top(a), &y = counts_.top(b), &z = counts_.top(c);
      normals.push_back(normalized(cross(y - x, z - x)));
      lengths += distance(top, x) + distance(top, y) + distance(top, z);
    }
    const double width = lengths / static_cast<double>(2 * normals.size());
    return {walls_.curve_to_region[curve], top, most_normal_direction(normals).direction, kRoom * width};
  }

  // Whether it has the top of the curve or of a neighbour: the side of a pit in the front is no other front.
  bool is_beside(std::size_t curve, std::uint32_t triangle) const {
    const auto& verts = surface_.mesh.tri_to_vert[triangle];
    return std::ranges::any_of(walls_.triangles_at(static_cast<std::uint32_t>(curve)), [&](std::uint32_t w) {
      return std::ranges::any_of(walls_.triangles[w].curves, [&](std::uint32_t c) {
        return std::ranges::count(verts, surface_.curve_to_top[c]) > 0;
      });
    });
  }

  const Walls& walls_;
  const LayerCounts& counts_;
  const LayeredSurface& surface_;
  const TaskRunner& runner_;
  std::vector<LookAhead> looks_;  // per curve
};

}  // namespace

std::vector<double> find_lacking_room(const Walls& walls, const LayerCounts& counts, const LayeredSurface& surface,
                                      std::span<const std::uint8_t> asked, const TaskRunner& runner) {
  return RoomSearch(walls, counts, surface, runner).run(asked);
}

}  // namespace tetloom::layers
