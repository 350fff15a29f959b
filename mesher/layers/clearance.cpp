#include "mesher/layers/clearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tetloom::layers {
namespace {

constexpr std::size_t kGrain = 256;
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

class WallSearch {
 public:
  explicit WallSearch(const OppositeSurface& surface) : surface_(surface) {}

  Clearance from(std::size_t number, const LookAhead& look) const {
    Clearance nearest;
    for (const Vec3& ray : rays_about(look.direction)) {
      const Vec3 along = std::min(look.reach, nearest.distance) * ray;
      surface_.tree.for_each_along(look.point, along, [&](std::uint32_t t) {
        const double met = crossing(surface_.tree.corners_of(t), look.point, along) * norm(along);
        if (met >= std::min(look.reach, nearest.distance) || surface_.is_beside(number, t)) return;
        const bool is_front = faces(t, ray);
        const FaceSides& sides = surface_.tri_to_sides[t];
        if ((is_front ? sides.front : sides.back).value != look.region || !opposes(t, is_front, look.direction)) return;
        const double at = std::max(met, met * dot(normal_of(t), ray) / dot(normal_of(t), look.direction));
        if (at < nearest.distance) nearest = {at, surface_.has_layers[2 * t + is_front] != 0};
      });
    }
    return nearest;
  }

 private:
  Vec3 normal_of(std::uint32_t triangle) const {
    const auto [a, b, c] = surface_.tree.corners_of(triangle);
    return normalized(cross(b - a, c - a));
  }
  // Whether the ray comes from the front of the triangle.
  bool faces(std::uint32_t triangle, const Vec3& ray) const { return dot(normal_of(triangle), ray) < 0; }
  bool opposes(std::uint32_t triangle, bool is_front, const Vec3& direction) const {
    return (is_front ? 1 : -1) * dot(normal_of(triangle), direction) < kFacing;
  }

  const OppositeSurface& surface_;
};

}  // namespace

std::vector<Clearance> find_clearances(const OppositeSurface& surface, std::span<const LookAhead> looks,
                                       const TaskRunner& runner) {
  const WallSearch search(surface);
  std::vector<Clearance> clearances(looks.size());
  runner.for_blocks(clearances.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (looks[i].direction != Vec3{}) clearances[i] = search.from(i, looks[i]);
  });
  return clearances;
}

}  // namespace tetloom::layers
