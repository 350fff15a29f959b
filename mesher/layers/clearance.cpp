#include "mesher/layers/clearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "core/base/grain.hpp"
#include "core/spatial/morton.hpp"

namespace tetloom::layers {
namespace {

constexpr std::size_t kRays = 7;                   // the axis and six around it
constexpr double kCosOfCone = 0.9063077870366499;  // of 25 degrees; 60 lose a sixth of concave insides
constexpr double kSinOfCone = 0.42261826174069944, kSin60 = 0.8660254037844386;
constexpr double kFacing = -0.3;  // cosine between the ray's curve and the normal of what faces it

constexpr std::size_t kMostTogether = 16;  // looks that search as one
constexpr double kSpreadTogether = 3;      // the box around them, over the largest of theirs

std::array<Vec3, kRays> rays_about(const Vec3& axis) {
  constexpr std::array<std::array<double, 2>, kRays - 1> kTurns{
      {{1, 0}, {.5, kSin60}, {-.5, kSin60}, {-1, 0}, {-.5, -kSin60}, {.5, -kSin60}}};
  const Vec3 other = std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 first = normalized(cross(axis, other)), second = cross(axis, first);
  std::array<Vec3, kRays> rays{axis};
  for (std::size_t i = 1; i < kRays; ++i)
    rays[i] = kCosOfCone * axis + kSinOfCone * (kTurns[i - 1][0] * first + kTurns[i - 1][1] * second);
  return rays;
}

// The share of the ray up to a triangle (closed), after Möller & Trumbore (1997); 2 where it is not met.
double crossing(const std::array<Vec3, 3>& x, const Vec3& from, const Vec3& ray) {
  constexpr double kMissed = 2;
  const Vec3 p = cross(ray, x[2] - x[0]);
  const double det = dot(x[1] - x[0], p);
  if (det == 0) return kMissed;
  const Vec3 s = from - x[0], q = cross(s, x[1] - x[0]);
  const double u = dot(s, p) / det, v = dot(ray, q) / det, at = dot(x[2] - x[0], q) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && at > 0 ? at : kMissed;
}

Box3 box_around(const Vec3& point, std::span<const Vec3> rays, double reach) {
  Box3 box;
  box.add(point);
  for (const Vec3& ray : rays) box.add(point + reach * ray);
  return box;
}

// Directions within an angle of an axis.
struct LookCone {
  Vec3 axis;
  double cosine = 1, sine = 0;

  explicit LookCone(std::span<const LookAhead* const> looks) {
    constexpr double kRounding = 1e-9;
    Vec3 sum;
    for (const LookAhead* look : looks) sum += look->direction;
    axis = normalized(sum);
    for (const LookAhead* look : looks) cosine = std::min(cosine, dot(axis, look->direction));
    cosine = std::max(-1.0, cosine - kRounding);
    sine = std::sqrt(1 - cosine * cosine);
  }
  // The least cosine between a direction of the cone and one of which the cosine to the axis is known.
  double least_to(double at_axis) const {
    if (at_axis <= -cosine) return -1;
    return at_axis * cosine - std::sqrt(std::max(0.0, 1 - at_axis * at_axis)) * sine;
  }
};

// Looks from places near to each other, in one region. What faces none of them is left out once for all: where there
// are no walls opposite, that is everything.
class WallSearch {
 public:
  explicit WallSearch(const OppositeSurface& surface) : surface_(surface) {}

  // Pre: at most kMostTogether looks.
  void gather(std::span<const LookAhead* const> looks, const Box3& box) {
    leaves_.clear(), faced_.clear();
    const LookCone cone(looks);
    const std::uint32_t region = looks[0]->region;
    surface_.tree.for_each_leaf_in(box, 0, [&](std::size_t number) {
      Leaf leaf{{}, faced_.size(), 0};
      for (const std::uint32_t t : surface_.tree.leaf_triangles(number)) {
        const std::array<Vec3, 3> corners = surface_.tree.corners_of(t);
        const Vec3 across = cross(corners[1] - corners[0], corners[2] - corners[0]), normal = normalized(across);
        const FaceSides& sides = surface_.tri_to_sides[t];
        const double turned = dot(normal, cone.axis);
        const bool shows_front = sides.front.value == region && cone.least_to(turned) < kFacing;
        const bool shows_back = sides.back.value == region && cone.least_to(-turned) < kFacing;
        if (!shows_front && !shows_back) continue;
        faced_.push_back({corners, normal, t, shows_front, shows_back});
        for (const Vec3& corner : corners) leaf.box.add(corner);
      }
      leaf.end = faced_.size();
      if (leaf.end > leaf.begin) leaves_.push_back(leaf);
    });
  }

  Clearance from(std::size_t number, const LookAhead& look) {
    Clearance nearest;
    if (leaves_.empty()) return nearest;
    const auto rays = rays_about(look.direction);
    // What the axis meets ends the others.
    follow(number, look, std::span(rays).first(1), nearest);
    follow(number, look, std::span(rays).subspan(1), nearest);
    return nearest;
  }

 private:
  // A triangle that looks may face, and its sides on which they do.
  struct Faced {
    std::array<Vec3, 3> corners;
    Vec3 normal;
    std::uint32_t triangle = 0;
    bool shows_front = false, shows_back = false;
  };
  struct Leaf {
    Box3 box;
    std::size_t begin = 0, end = 0;  // in faced_
  };
  // A triangle that rays may meet, and the side on which they do.
  struct Opposite {
    const Faced* faced = nullptr;
    bool is_front = false;
  };

  void follow(std::size_t number, const LookAhead& look, std::span<const Vec3> rays, Clearance& nearest) {
    find_opposite(number, look, rays, std::min(look.reach, nearest.distance));
    if (opposite_.empty()) return;
    for (const Vec3& ray : rays) {
      const Vec3 along = std::min(look.reach, nearest.distance) * ray;
      for (const auto& [faced, is_front] : opposite_) {
        const double met = crossing(faced->corners, look.point, along) * norm(along);
        if (met >= std::min(look.reach, nearest.distance) || (dot(faced->normal, ray) < 0) != is_front) continue;
        const double at = std::max(met, met * dot(faced->normal, ray) / dot(faced->normal, look.direction));
        if (at < nearest.distance) nearest = {at, surface_.has_layers[2 * faced->triangle + is_front] != 0};
      }
    }
  }

  void find_opposite(std::size_t number, const LookAhead& look, std::span<const Vec3> rays, double reach) {
    opposite_.clear(), segments_.clear();
    const Box3 box = box_around(look.point, rays, reach);
    for (const Vec3& ray : rays) segments_.emplace_back(look.point, reach * ray);
    for (const Leaf& leaf : leaves_) {
      if (!leaf.box.overlaps(box)) continue;
      if (std::ranges::none_of(segments_, [&](const auto& meets) { return meets(leaf.box); })) continue;
      for (std::size_t i = leaf.begin; i < leaf.end; ++i) {
        const Faced& one = faced_[i];
        const double turned = dot(one.normal, look.direction);
        const bool is_front = turned < 0;
        if ((is_front ? one.shows_front : one.shows_back) && -std::abs(turned) < kFacing &&
            !surface_.is_beside(number, one.triangle))
          opposite_.push_back({&one, is_front});
      }
    }
  }

  const OppositeSurface& surface_;
  std::vector<Leaf> leaves_;  // of those that search together
  std::vector<Faced> faced_;
  std::vector<intersection::SegmentBoxTest> segments_;  // of the rays at hand
  std::vector<Opposite> opposite_;
};

// Those with a direction, region by region, neighbours in space after each other.
std::vector<std::uint32_t> sorted_by_place(std::span<const LookAhead> looks) {
  struct Key {
    std::uint32_t region = 0, look = 0;
    std::uint64_t code = 0;
  };
  Box3 all;
  for (const LookAhead& look : looks)
    if (look.direction != Vec3{}) all.add(look.point);
  const Vec3 extent = all.hi - all.lo;
  const double scale = kMostMorton / std::max({extent.x, extent.y, extent.z, 1e-300});
  std::vector<Key> keys;
  for (std::uint32_t i = 0; i < looks.size(); ++i) {
    if (looks[i].direction == Vec3{}) continue;
    keys.push_back({looks[i].region, i, morton_of(looks[i].point, all.lo, scale)});
  }
  std::ranges::sort(keys, {}, [](const Key& key) { return std::tuple(key.region, key.code, key.look); });
  std::vector<std::uint32_t> sorted;
  for (const Key& key : keys) sorted.push_back(key.look);
  return sorted;
}

// The first of the looks that may search together, as many as there are; the box around them.
Box3 take_together(std::span<const LookAhead> looks, std::span<const std::uint32_t> sorted,
                   std::vector<const LookAhead*>& together) {
  together.clear();
  Box3 all;
  double largest = 0;
  for (const std::uint32_t number : sorted.first(std::min(sorted.size(), kMostTogether))) {
    const LookAhead& look = looks[number];
    Box3 box = box_around(look.point, rays_about(look.direction), look.reach);
    largest = std::max(largest, box.diagonal());
    box.add(all);
    const bool fits =
        together.empty() || (look.region == together[0]->region && box.diagonal() <= kSpreadTogether * largest);
    if (!fits) break;
    all = box;
    together.push_back(&look);
  }
  return all;
}

}  // namespace

std::vector<Clearance> find_clearances(const OppositeSurface& surface, std::span<const LookAhead> looks,
                                       const TaskRunner& runner) {
  std::vector<Clearance> clearances(looks.size());
  const std::vector<std::uint32_t> sorted = sorted_by_place(looks);
  runner.for_blocks(sorted.size(), kSearchGrain, [&](std::size_t begin, std::size_t end) {
    WallSearch search(surface);
    std::vector<const LookAhead*> together;
    for (; begin < end; begin += together.size()) {
      const Box3 box = take_together(looks, std::span(sorted).subspan(begin, end - begin), together);
      search.gather(together, box);
      for (std::size_t i = 0; i < together.size(); ++i)
        clearances[sorted[begin + i]] = search.from(sorted[begin + i], *together[i]);
    }
  });
  return clearances;
}

}  // namespace tetloom::layers
