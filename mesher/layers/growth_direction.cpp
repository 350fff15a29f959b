#include "mesher/layers/growth_direction.hpp"

#include <algorithm>

namespace tetloom::layers {
namespace {

// The axis of a cone that has some normals on its surface; of the two, the one nearer to them.
Vec3 axis_of(const Vec3& a, const Vec3& b) { return normalized(a + b); }
Vec3 axis_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 axis = normalized(cross(b - a, c - a));
  return dot(axis, a) < 0 ? -axis : axis;
}

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

}  // namespace tetloom::layers
