#include "core/discrete/pinched_points.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace tetloom::detail {
namespace {

using Halves = std::vector<std::uint32_t>;  // that begin at one point

/// Walks around points from facet to facet, across joints.
class FanWalker {
 public:
  explicit FanWalker(const FacetSurface& surface) : surface_(surface) {}

  // The half-edges of the fan that `start` belongs to, from the same point. Whether the fan goes all around it.
  bool collect(std::uint32_t start, Halves& fan) const {
    fan.assign(1, start);
    for (std::uint32_t half = left_of(start); half != kNone; half = left_of(half)) {
      if (half == start) return true;
      fan.push_back(half);
    }
    for (std::uint32_t half = right_of(start); half != kNone; half = right_of(half)) fan.push_back(half);
    return false;
  }

 private:
  std::uint32_t across(std::uint32_t half) const {
    return surface_.edge_is_joint[surface_.edges.half_to_edge[half]] ? surface_.edges.twin(half) : kNone;
  }
  std::uint32_t left_of(std::uint32_t half) const { return across(previous_half(half)); }
  std::uint32_t right_of(std::uint32_t half) const {
    const std::uint32_t other = across(half);
    return other == kNone ? kNone : next_half(other);
  }

  const FacetSurface& surface_;
};

// Of each of some points, all half-edges that begin there.
std::map<std::uint32_t, Halves> halves_from(const std::vector<std::uint32_t>& points, const FacetSurface& surface) {
  std::map<std::uint32_t, Halves> from;
  for (const std::uint32_t v : points) from[v];
  std::vector<bool> is_wanted(surface.points.size(), false);
  for (const std::uint32_t v : points) is_wanted[v] = true;
  for (std::uint32_t half = 0; half < 3 * surface.tri_to_vert.size() && !points.empty(); ++half)
    if (const std::uint32_t v = surface.origin(half); is_wanted[v]) from[v].push_back(half);
  return from;
}

// Walls that begin at a point in a fan without any.
class SlitMaker {
 public:
  SlitMaker(const FacetSurface& surface, std::vector<bool>& walls) : surface_(surface), walls_(walls) {
    is_on_wall_.assign(surface.points.size(), false);
    for (std::uint32_t edge = 0; edge < walls.size(); ++edge)
      if (walls[edge]) mark(edge);
  }

  void cut(const Halves& fan) {
    const auto edge_of = [&](std::uint32_t half) { return surface_.edges.half_to_edge[half]; };
    if (std::ranges::any_of(fan, [&](std::uint32_t half) { return walls_[edge_of(half)]; })) return;
    if (std::ranges::any_of(fan, [&](std::uint32_t half) { return walls_[edge_of(previous_half(half))]; })) return;
    // An edge between two points that are on no other wall has the same corners on both of its sides, so there are two.
    const auto free = std::ranges::find_if(fan, [&](std::uint32_t half) { return !is_on_wall_[surface_.head(half)]; });
    if (free == fan.end()) return add(edge_of(fan.front()));
    const std::uint32_t ahead = straight_on(*free);
    add(edge_of(*free));
    if (ahead != kNone) add(edge_of(ahead));
  }

 private:
  void mark(std::uint32_t edge) {
    for (const std::uint32_t v : surface_.edges.edge_to_vert[edge]) is_on_wall_[v] = true;
  }
  void add(std::uint32_t edge) {
    walls_[edge] = true;
    mark(edge);
  }

  // The half-edge from the head of `half` that turns least, of those that end on no wall where there are any.
  std::uint32_t straight_on(std::uint32_t half) const {
    Halves fan;
    FanWalker(surface_).collect(next_half(half), fan);
    const Vec3 middle = surface_.points[surface_.head(half)];
    const Vec3 along = normalized(middle - surface_.points[surface_.origin(half)]);
    std::uint32_t best = kNone;
    std::pair<bool, double> best_worth;
    for (const std::uint32_t next : fan) {
      const std::uint32_t head = surface_.head(next);
      if (head == surface_.origin(half)) continue;
      const std::pair worth{!is_on_wall_[head], dot(along, normalized(surface_.points[head] - middle))};
      if (best == kNone || worth > best_worth) best = next, best_worth = worth;
    }
    return best;
  }

  const FacetSurface& surface_;
  std::vector<bool>& walls_;
  std::vector<bool> is_on_wall_;
};

}  // namespace

std::vector<std::uint32_t> find_pinched_points(const FacetSurface& surface) {
  std::vector<std::uint32_t> count(surface.points.size(), 0), first(surface.points.size(), kNone);
  for (std::uint32_t half = 0; half < 3 * surface.tri_to_vert.size(); ++half) {
    const std::uint32_t v = surface.origin(half);
    if (count[v]++ == 0) first[v] = half;
  }
  const FanWalker walker(surface);
  std::vector<std::uint32_t> candidates, pinched;
  Halves fan;
  for (std::uint32_t v = 0; v < surface.points.size(); ++v) {
    if (count[v] == 0) continue;
    walker.collect(first[v], fan);
    if (fan.size() < count[v]) candidates.push_back(v);
  }
  // Where all fans end at edges that are no joints, as along an edge of four facets, these bound faces already.
  for (const auto& [v, halves] : halves_from(candidates, surface))
    if (std::ranges::any_of(halves, [&](std::uint32_t half) { return walker.collect(half, fan); }))
      pinched.push_back(v);
  return pinched;
}

void add_walls_at(const std::vector<std::uint32_t>& pinched_points, const FacetSurface& surface,
                  std::vector<bool>& walls) {
  if (pinched_points.empty()) return;
  const FanWalker walker(surface);
  SlitMaker slits(surface, walls);
  Halves fan;
  for (auto& [v, halves] : halves_from(pinched_points, surface)) {
    while (!halves.empty()) {
      walker.collect(halves.front(), fan);
      slits.cut(fan);
      std::erase_if(halves, [&](std::uint32_t half) { return std::ranges::count(fan, half) > 0; });
    }
  }
}

}  // namespace tetloom::detail
