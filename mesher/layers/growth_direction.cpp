#include "mesher/layers/growth_direction.hpp"

#include <algorithm>
#include <cmath>

namespace tetloom::layers {
namespace {

// The axis of a cone that has some normals on its surface; of the two, the one nearer to them.
Vec3 axis_of(const Vec3& a, const Vec3& b) { return normalized(a + b); }
Vec3 axis_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 axis = normalized(cross(b - a, c - a));
  return dot(axis, a) < 0 ? -axis : axis;
}

constexpr double kBent = 0.3;     // squared sine off the middle: a front that turns by 66 degrees has an edge
constexpr double kWithin = 1e-9;  // of cosines: within the cone

class SmallestCone {
 public:
  explicit SmallestCone(std::span<const Vec3> normals) : normals_(normals) {}

  // As the smallest circle around points is found (Welzl 1991).
  Vec3 axis() {
    if (normals_.empty()) return {};
    take(normals_[0], 1);
    for (std::size_t i = 1; i < normals_.size(); ++i)
      if (!holds(normals_[i])) around_one(i);
    return axis_;
  }

 private:
  void take(const Vec3& axis, double cosine) { axis_ = axis, cosine_ = cosine; }
  bool holds(const Vec3& normal) const { return dot(normal, axis_) >= cosine_ - kWithin; }

  void around_one(std::size_t i) {
    take(normals_[i], 1);
    for (std::size_t j = 0; j < i; ++j)
      if (!holds(normals_[j])) around_two(i, j);
  }
  void around_two(std::size_t i, std::size_t j) {
    const Vec3 between = axis_of(normals_[i], normals_[j]);
    take(between, dot(between, normals_[i]));
    for (std::size_t k = 0; k < j; ++k) {
      if (holds(normals_[k])) continue;
      const Vec3 among = axis_of(normals_[i], normals_[j], normals_[k]);
      take(among, dot(among, normals_[i]));
    }
  }

  std::span<const Vec3> normals_;
  Vec3 axis_;
  double cosine_ = 1;
};

}  // namespace

double visibility_of(const Vec3& direction, std::span<const Vec3> normals) {
  double least = 1;
  for (const Vec3& normal : normals) least = std::min(least, dot(direction, normal));
  return least;
}

GrowthDirection most_normal_direction(std::span<const Vec3> normals) {
  const Vec3 axis = SmallestCone(normals).axis();
  return {axis, axis == Vec3{} ? 0 : visibility_of(axis, normals)};
}

FrontFreedom find_freedom(std::span<const Vec3> normals) {
  const Vec3 middle = SmallestCone(normals).axis();
  if (middle == Vec3{}) return {};
  const Vec3 first = normalized(cross(middle, std::abs(middle.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  const Vec3 second = cross(middle, first);
  double xx = 0, xy = 0, yy = 0;
  for (const Vec3& normal : normals) {
    const double x = dot(normal, first), y = dot(normal, second);
    xx += x * x, xy += x * y, yy += y * y;
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  const Vec3 most = std::cos(angle) * first + std::sin(angle) * second, least = cross(middle, most);
  const auto freed = [&](const Vec3& axis) {
    double off = 0;
    for (const Vec3& normal : normals) off = std::max(off, dot(normal, axis) * dot(normal, axis));
    return std::sqrt(std::max(0.0, 1 - off / kBent)) * axis;
  };
  return {{freed(most), freed(least)}};
}

}  // namespace tetloom::layers
