#include "mesher/layers/clearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/grain.hpp"

namespace tetloom::layers {
namespace {

constexpr std::size_t kRays = 7;     // the axis and six around it
constexpr double kConeDegrees = 25;  // 60 degrees lose a sixth of concave insides
constexpr double kFacing = -0.3;     // cosine between the ray's curve and the normal of what faces it

std::array<Vec3, kRays> rays_about(const Vec3& axis) {
  constexpr double kAngle = kConeDegrees * std::numbers::pi / 180;
  const Vec3 other = std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 first = normalized(cross(axis, other)), second = cross(axis, first);
  std::array<Vec3, kRays> rays{axis};
  for (std::size_t i = 1; i < kRays; ++i) {
    const double turn = static_cast<double>(i - 1) * std::numbers::pi / 3;
    rays[i] = std::cos(kAngle) * axis + std::sin(kAngle) * (std::cos(turn) * first + std::sin(turn) * second);
  }
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

// Looks from one place after the other.
class WallSearch {
 public:
  explicit WallSearch(const OppositeSurface& surface) : surface_(surface) {}

  Clearance from(std::size_t number, const LookAhead& look) {
    const auto rays = rays_about(look.direction);
    Clearance nearest;
    // What the axis meets ends the others.
    follow(number, look, std::span(rays).first(1), nearest);
    follow(number, look, std::span(rays).subspan(1), nearest);
    return nearest;
  }

 private:
  // A triangle that rays may meet, and the side on which they do.
  struct Opposite {
    std::array<Vec3, 3> corners;
    Vec3 normal;
    std::uint32_t triangle = 0;
    bool is_front = false;
  };

  void follow(std::size_t number, const LookAhead& look, std::span<const Vec3> rays, Clearance& nearest) {
    find_opposite(number, look, rays, std::min(look.reach, nearest.distance));
    if (opposite_.empty()) return;
    for (const Vec3& ray : rays) {
      const Vec3 along = std::min(look.reach, nearest.distance) * ray;
      for (const Opposite& one : opposite_) {
        const double met = crossing(one.corners, look.point, along) * norm(along);
        if (met >= std::min(look.reach, nearest.distance) || (dot(one.normal, ray) < 0) != one.is_front) continue;
        const double at = std::max(met, met * dot(one.normal, ray) / dot(one.normal, look.direction));
        if (at < nearest.distance) nearest = {at, surface_.has_layers[2 * one.triangle + one.is_front] != 0};
      }
    }
  }

  // Most of what is near faces elsewhere.
  void find_opposite(std::size_t number, const LookAhead& look, std::span<const Vec3> rays, double reach) {
    opposite_.clear(), segments_.clear();
    Box3 box;
    box.add(look.point);
    for (const Vec3& ray : rays) segments_.emplace_back(look.point, reach * ray), box.add(look.point + reach * ray);
    surface_.tree.for_each_near(segments_, box, [&](std::uint32_t t) {
      const std::array<Vec3, 3> corners = surface_.tree.corners_of(t);
      const Vec3 across = cross(corners[1] - corners[0], corners[2] - corners[0]);
      const bool is_front = dot(across, look.direction) < 0;
      const FaceSides& sides = surface_.tri_to_sides[t];
      if ((is_front ? sides.front : sides.back).value != look.region) return;
      const Vec3 normal = normalized(across);
      if ((is_front ? 1 : -1) * dot(normal, look.direction) < kFacing && !surface_.is_beside(number, t))
        opposite_.push_back({corners, normal, t, is_front});
    });
  }

  const OppositeSurface& surface_;
  // Of the rays at hand.
  std::vector<intersection::SegmentBoxTest> segments_;
  std::vector<Opposite> opposite_;
};

}  // namespace

std::vector<Clearance> find_clearances(const OppositeSurface& surface, std::span<const LookAhead> looks,
                                       const TaskRunner& runner) {
  std::vector<Clearance> clearances(looks.size());
  runner.for_blocks(clearances.size(), kSearchGrain, [&](std::size_t begin, std::size_t end) {
    WallSearch search(surface);
    for (std::size_t i = begin; i < end; ++i)
      if (looks[i].direction != Vec3{}) clearances[i] = search.from(i, looks[i]);
  });
  return clearances;
}

}  // namespace tetloom::layers
