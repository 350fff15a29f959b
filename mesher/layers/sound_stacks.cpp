#include "mesher/layers/sound_stacks.hpp"

#include <cmath>

#include "core/base/grain.hpp"

namespace tetloom::layers {
namespace {

constexpr double kKept = 0.8;      // of the first layer's, or of the wall triangle's sine
constexpr double kSqueezed = 0.8;  // of the wall triangle's width: fronts that only stretch are not meant
constexpr float kLeastSine = 0.26f, kLeastSineBent = 0.39f;  // of 15 and 23 degrees
constexpr double kBentLeast = 0.9994, kBentMost = 0.82;      // cosines of 2 and 35 degrees

// Of a triangle: the sine of its smallest angle, and its height above the longest edge.
struct TriangleShape {
  double sine = 0, width = 0;
};

TriangleShape shape_of(const std::array<Vec3, 3>& x) {
  std::array<double, 3> lengths{distance(x[0], x[1]), distance(x[1], x[2]), distance(x[2], x[0])};
  std::ranges::sort(lengths);
  const double area2 = norm(cross(x[1] - x[0], x[2] - x[0]));
  if (!(lengths[1] > 0)) return {};
  return {area2 / (lengths[1] * lengths[2]), area2 / lengths[2]};
}

std::array<Vec3, 3> corners_of(const WallTriangle& wall, std::span<const Vec3> feet) {
  return {feet[wall.curves[0]], feet[wall.curves[1]], feet[wall.curves[2]]};
}

}  // namespace

SoundStacks::SoundStacks(const Walls& walls, std::span<const Vec3> feet, const TaskRunner& runner)
    : walls_(walls), limits_(walls.triangles.size()) {
  std::vector<Vec3> normals(walls.triangles.size());
  const auto for_each_wall = [&](const auto& body) {
    runner.for_blocks(walls.triangles.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
      for (auto w = static_cast<std::uint32_t>(begin); w < end; ++w) body(w);
    });
  };
  for_each_wall([&](std::uint32_t w) {
    const auto [a, b, c] = corners_of(walls.triangles[w], feet);
    normals[w] = normalized(cross(b - a, c - a));
  });
  for_each_wall([&](std::uint32_t w) { limits_[w] = limits_of(w, feet, normals); });
}

SoundStacks::Limits SoundStacks::limits_of(std::uint32_t wall, std::span<const Vec3> feet,
                                           std::span<const Vec3> normals) const {
  const auto [sine, width] = shape_of(corners_of(walls_.triangles[wall], feet));
  const float least = is_bent_at(wall, normals) ? kLeastSineBent : kLeastSine;
  return {static_cast<float>(kSqueezed * width), std::min(least, static_cast<float>(kKept * sine))};
}

// Whether it and a triangle that touches it are at an angle, but at no sharp edge.
bool SoundStacks::is_bent_at(std::uint32_t wall, std::span<const Vec3> normals) const {
  return std::ranges::any_of(walls_.triangles[wall].curves, [&](std::uint32_t curve) {
    return std::ranges::any_of(walls_.triangles_at(curve), [&](std::uint32_t other) {
      const double cosine = dot(normals[wall], normals[other]);
      return cosine > kBentMost && cosine < kBentLeast;
    });
  });
}

bool SoundStacks::is_wide_enough(std::uint32_t wall, const std::array<Vec3, 3>& front) const {
  const auto [sine, width] = shape_of(front);
  return width >= limits_[wall].width || sine >= limits_[wall].sine;
}

double SoundStacks::least_above(double least, double jacobian_of_first) {
  return jacobian_of_first >= least ? least : std::max(kLeastFirst, kKept * jacobian_of_first);
}

}  // namespace tetloom::layers
