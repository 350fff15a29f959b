#include "mesher/layers/front_spreading.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/grain.hpp"

namespace tetloom::layers {
namespace {

constexpr int kSpreadingSweeps = 12;
constexpr double kChanging = 0.02;     // of the lengths of the wall's edges
constexpr double kLeastWeight = 0.05;  // blunt angles count little

}  // namespace

FrontSpreading::FrontSpreading(const Walls& walls, std::span<const Vec3> feet)
    : walls_(walls), feet_(feet.begin(), feet.end()) {
  const auto weight_at = [&](const std::array<std::uint32_t, 3>& curves, std::size_t i) {
    const Vec3 a = feet[curves[(i + 1) % 3]] - feet[curves[i]], b = feet[curves[(i + 2) % 3]] - feet[curves[i]];
    return static_cast<float>(std::max(kLeastWeight, dot(a, b) / std::max(norm(cross(a, b)), 1e-300)));
  };
  neighbours_.reserve(2 * walls.curve_triangles.size());
  for (std::uint32_t c = 0; c < walls.curve_count(); ++c)
    for (const std::uint32_t w : walls.triangles_at(c)) {
      const auto& curves = walls.triangles[w].curves;
      for (std::size_t i = 0; i < 3; ++i) {
        if (curves[i] == c) continue;
        const std::size_t opposite = curves[(i + 1) % 3] == c ? (i + 2) % 3 : (i + 1) % 3;
        neighbours_.push_back({curves[i], weight_at(curves, opposite)});
      }
    }
}

bool FrontSpreading::changes_at(std::span<const Vec3> ways, std::uint32_t curve) const {
  double growth = 0, size = 0;
  for (const Neighbour& other : neighbours_of(curve)) {
    const Vec3 edge = feet_[other.curve] - feet_[curve];
    growth += dot(ways[other.curve] - ways[curve], edge);
    size += norm2(edge);
  }
  return std::abs(growth) > kChanging * size;
}

// `shifted` are the ways with the shifts of the last sweep.
Vec3 FrontSpreading::shift_at(const ChangingFront& front, const std::vector<Vec3>& ways,
                              const std::vector<Vec3>& shifted, std::uint32_t curve) const {
  Vec3 sum;
  double weights = 0;
  for (const Neighbour& other : neighbours_of(curve)) {
    sum += static_cast<double>(other.weight) * shifted[other.curve];
    weights += static_cast<double>(other.weight);
  }
  const Vec3 within = front.freedom[curve].within(sum / weights - ways[curve]);
  return std::min(1.0, front.most[curve] / std::max(norm(within), 1e-300)) * within;
}

std::vector<Vec3> FrontSpreading::find_shifts(const ChangingFront& front, const TaskRunner& runner) const {
  const std::size_t count = feet_.size();
  std::vector<Vec3> shifts(count), ways(count);
  std::vector<std::uint8_t> is_changing(count, 0);
  const auto for_each = [&](std::size_t items, const auto& body) {
    runner.for_blocks(items, kStarGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) body(i);
    });
  };
  for_each(count, [&](std::size_t c) { ways[c] = front.points[c] - feet_[c]; });
  for_each(count, [&](std::size_t c) {
    is_changing[c] = front.is_free[c] && changes_at(ways, static_cast<std::uint32_t>(c));
  });
  std::vector<std::uint32_t> changing;
  for (std::uint32_t c = 0; c < count; ++c)
    if (is_changing[c]) changing.push_back(c);
  if (changing.empty()) return shifts;
  std::vector<Vec3> shifted = ways;
  for (int sweep = 0; sweep < kSpreadingSweeps; ++sweep) {
    for_each(changing.size(),
             [&](std::size_t i) { shifts[changing[i]] = shift_at(front, ways, shifted, changing[i]); });
    for_each(changing.size(), [&](std::size_t i) { shifted[changing[i]] = ways[changing[i]] + shifts[changing[i]]; });
  }
  return shifts;
}

}  // namespace tetloom::layers
