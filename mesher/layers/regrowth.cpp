#include "mesher/layers/regrowth.hpp"

#include <algorithm>

namespace tetloom::layers {
namespace {

// The curve at the same corner of a wall triangle, where it has the same triangles around it; or none.
std::uint32_t same_at_walls(const Walls& walls, const Walls& before, std::uint32_t curve) {
  const auto triangles = walls.triangles_at(curve);
  const auto& curves = walls.triangles[triangles[0]].curves;
  const auto corner = std::ranges::find(curves, curve) - curves.begin();
  const std::uint32_t other = before.triangles[triangles[0]].curves[static_cast<std::size_t>(corner)];
  const bool same = std::ranges::equal(triangles, before.triangles_at(other)) &&
                    walls.curve_is_late[curve] == before.curve_is_late[other] &&
                    (walls.curve_to_fan_vertex[curve] == kNone) == (before.curve_to_fan_vertex[other] == kNone);
  return same ? other : kNone;
}

// All curves of one foot, or none of them.
void match_fan(const Walls& walls, const Walls& before, const FanVertex& fan, std::vector<std::uint32_t>& kept) {
  const std::uint32_t first = kept[fan.curves.front()];
  std::vector<std::uint32_t> others;
  if (first != kNone) others = before.fan_vertices[before.curve_to_fan_vertex[first]].curves;
  bool same = others.size() == fan.curves.size();
  for (std::size_t i = 0; same && i < others.size(); ++i)
    same = walls.triangles_at(fan.curves[i]).empty()
               ? walls.curve_to_direction[fan.curves[i]] == before.curve_to_direction[others[i]]
               : kept[fan.curves[i]] == others[i];
  for (std::size_t i = 0; i < fan.curves.size(); ++i) kept[fan.curves[i]] = same ? others[i] : kNone;
}

// One edge further, and over all curves of a foot.
void spread(const Walls& walls, std::vector<std::uint32_t>& kept) {
  std::vector<std::uint32_t> next = kept;
  const auto lose_around = [&](std::span<const std::uint32_t> curves) {
    if (std::ranges::any_of(curves, [&](std::uint32_t c) { return kept[c] == kNone; }))
      for (const std::uint32_t c : curves) next[c] = kNone;
  };
  for (std::size_t stack = 0; stack < walls.stack_count(); ++stack) lose_around(walls.curves_of(stack));
  kept = next;
  for (const FanVertex& fan : walls.fan_vertices) lose_around(fan.curves);
  kept = std::move(next);
}

}  // namespace

std::vector<std::uint32_t> find_kept_curves(const Walls& walls, const Walls& before, int rings) {
  std::vector<std::uint32_t> kept(walls.curve_count(), kNone);
  for (std::uint32_t c = 0; c < kept.size(); ++c)
    if (!walls.triangles_at(c).empty()) kept[c] = same_at_walls(walls, before, c);
  for (const FanVertex& fan : walls.fan_vertices) match_fan(walls, before, fan, kept);
  for (int ring = 0; ring < rings; ++ring) spread(walls, kept);
  return kept;
}

}  // namespace tetloom::layers
