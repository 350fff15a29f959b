#include "mesher/layers/front_spreading.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/grain.hpp"

namespace tetloom::layers {
namespace {

constexpr int kSpreadingSweeps = 12;
constexpr double kChanging = 0.02;     // of the lengths of the wall's edges
constexpr double kLeastWeight = 0.05;  // blunt angles count little

}  // namespace

FrontSpreading::FrontSpreading(const Walls& walls, std::span<const Vec3> feet)
    : walls_(walls), feet_(feet.begin(), feet.end()), weights_(walls.triangles.size()) {
  for (std::size_t w = 0; w < weights_.size(); ++w)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& curves = walls.triangles[w].curves;
      const Vec3 a = feet[curves[(i + 1) % 3]] - feet[curves[i]], b = feet[curves[(i + 2) % 3]] - feet[curves[i]];
      weights_[w][i] = static_cast<float>(std::max(kLeastWeight, dot(a, b) / std::max(norm(cross(a, b)), 1e-300)));
    }
}

// Each neighbour once per triangle, with the cotangent of the angle that is opposite there.
template <class Visit>
void FrontSpreading::for_each_neighbour(std::uint32_t curve, const Visit& visit) const {
  for (const std::uint32_t w : walls_.triangles_at(curve)) {
    const auto& curves = walls_.triangles[w].curves;
    for (std::size_t i = 0; i < 3; ++i) {
      if (curves[i] == curve) continue;
      const std::size_t opposite = curves[(i + 1) % 3] == curve ? (i + 2) % 3 : (i + 1) % 3;
      visit(curves[i], weights_[w][opposite]);
    }
  }
}

bool FrontSpreading::changes_at(const ChangingFront& front, std::uint32_t curve) const {
  if (!front.is_free[curve]) return false;
  double growth = 0, size = 0;
  for_each_neighbour(curve, [&](std::uint32_t other, double) {
    const Vec3 edge = feet_[other] - feet_[curve];
    growth += dot(way(front, other) - way(front, curve), edge);
    size += norm2(edge);
  });
  return std::abs(growth) > kChanging * size;
}

Vec3 FrontSpreading::shift_at(const ChangingFront& front, const std::vector<Vec3>& shifts, std::uint32_t curve) const {
  Vec3 sum;
  double weights = 0;
  for_each_neighbour(curve, [&](std::uint32_t other, double weight) {
    sum += weight * (way(front, other) + shifts[other]);
    weights += weight;
  });
  const Vec3 within = front.freedom[curve].within(sum / weights - way(front, curve));
  return std::min(1.0, front.most[curve] / std::max(norm(within), 1e-300)) * within;
}

std::vector<Vec3> FrontSpreading::find_shifts(const ChangingFront& front, const TaskRunner& runner) const {
  const std::size_t count = feet_.size();
  std::vector<Vec3> shifts(count);
  std::vector<std::uint8_t> is_changing(count, 0);
  runner.for_blocks(count, kStarGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) is_changing[c] = changes_at(front, static_cast<std::uint32_t>(c));
  });
  std::vector<std::uint32_t> changing;
  for (std::uint32_t c = 0; c < count; ++c)
    if (is_changing[c]) changing.push_back(c);
  if (changing.empty()) return shifts;
  std::vector<Vec3> next = shifts;
  for (int sweep = 0; sweep < kSpreadingSweeps; ++sweep) {
    runner.for_blocks(changing.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) next[changing[i]] = shift_at(front, shifts, changing[i]);
    });
    shifts.swap(next);
  }
  return shifts;
}

}  // namespace tetloom::layers
