#include "mesher/features/cone.hpp"

#include <algorithm>
#include <cmath>

namespace tetloom::features {
namespace {

double angle_between(const Vec3& s, const Vec3& t) { return std::atan2(norm(cross(s, t)), dot(s, t)); }

bool is_inside(const Vec3& foot, const Cone& cone) {
  return dot(cross(cone.first, foot), cone.normal) >= 0 && dot(cross(foot, cone.last), cone.normal) >= 0;
}

// What lies over the inside of a cone is out of its plane; what lies beside it may be in it.
double one_way(const Cone& s, const Cone& t, double limit) {
  const double half_angle = std::acos(std::min(1.0, s.half_cosine));
  // A needle beside a cone may seem to be just over its side.
  constexpr double kClearly = 0.03;
  const double from_sides = std::min(angle_between(s.middle, t.first), angle_between(s.middle, t.last));
  const bool above =
      from_sides > std::max(1.1 * half_angle, kClearly) && is_inside(s.middle - dot(s.middle, t.normal) * t.normal, t);
  return angle_to_cone(s.middle, t) / (above ? limit : std::min(limit, 0.9 * half_angle));
}

// The cosine of half the cone's angle and 15 degrees together: a direction farther than that from the middle is at
// least 15 degrees from the cone.
double reach_cosine(const Cone& cone) {
  constexpr double kCosine = 0.9659258262890683, kSine = 0.25881904510252074;
  const double half_sine = std::sqrt(std::max(0.0, 1 - cone.half_cosine * cone.half_cosine));
  return cone.half_cosine * kCosine - half_sine * kSine;
}

}  // namespace

Cone make_cone(const Vec3& corner, const Vec3& b, const Vec3& c) {
  const Vec3 first = normalized(b - corner), last = normalized(c - corner), normal = cross(first, last);
  const double sine = norm(normal);
  constexpr double kFlat = 1e-9;
  if (sine < kFlat) return {first, last, {}, {}, 1};
  const Vec3 middle = normalized(first + last);
  return {first, last, middle, normal / sine, dot(first, middle)};
}

double angle_to_cone(const Vec3& direction, const Cone& cone) {
  const double height = dot(direction, cone.normal);
  const Vec3 foot = direction - height * cone.normal;
  if (is_inside(foot, cone)) return std::asin(std::min(1.0, std::abs(height)));
  return std::min(angle_between(direction, cone.first), angle_between(direction, cone.last));
}

double separation(const Cone& s, const Cone& t, double limit) {
  if (norm2(s.normal) == 0 || norm2(t.normal) == 0) return HUGE_VAL;
  const double between = dot(s.middle, t.middle);
  if (between < reach_cosine(s) && between < reach_cosine(t)) return HUGE_VAL;
  return std::min(one_way(s, t, limit), one_way(t, s, limit));
}

}  // namespace tetloom::features
