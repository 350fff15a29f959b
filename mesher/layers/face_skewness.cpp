#include "mesher/layers/face_skewness.hpp"

#include <algorithm>
#include <cmath>

namespace tetloom::layers {
namespace {

struct SideMeasures {
  Vec3 centre, area;  // the area points where the corners are seen counter-clockwise from
};

// Of the triangles about the mean of the corners.
SideMeasures measure(const CellSide& face) {
  Vec3 mean;
  double corners = 0;
  for (std::size_t i = 0; i < 4; ++i)
    if (face[i] != face[(i + 1) % 4]) mean += face[i], corners += 1;
  if (corners == 0) return {face[0], {}};
  mean = mean / corners;
  SideMeasures measures;
  double areas = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 &a = face[i], &b = face[(i + 1) % 4];
    const Vec3 across = 0.5 * cross(b - a, mean - a);
    const double area = norm(across);
    measures.centre += area / 3 * (a + b + mean), measures.area += across, areas += area;
  }
  measures.centre = areas > 0 ? measures.centre / areas : mean;
  return measures;
}

}  // namespace

Vec3 centre_of(std::span<const CellSide> sides) {
  constexpr std::size_t kMostSides = 6;
  std::array<SideMeasures, kMostSides> measured;
  Vec3 mean, sum;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    measured[i] = measure(sides[i]);
    mean += measured[i].centre / static_cast<double>(sides.size());
  }
  double volumes = 0;
  for (const SideMeasures& side : std::span(measured).first(sides.size())) {
    const double volume = dot(side.area, side.centre - mean);
    sum += volume * (0.75 * side.centre + 0.25 * mean), volumes += volume;
  }
  return volumes > 0 ? sum / volumes : mean;
}

Vec3 centre_of(const FrontCell& cell) {
  const auto& [low, high] = cell;
  std::array<CellSide, 5> sides{CellSide{low[0], low[2], low[1], low[1]}, CellSide{high[0], high[1], high[2], high[2]}};
  std::size_t count = 2;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t k = (i + 1) % 3;
    if (low[i] != high[i] || low[k] != high[k]) sides[count++] = {low[i], low[k], high[k], high[i]};
  }
  return centre_of(std::span(sides).first(count));
}

Vec3 rough_centre_of(const FrontCell& cell) {
  constexpr std::array<double, 4> kStays{1.0 / 3, 0.25, 0.25, 1.0 / 6}, kGrows{0, 0.25, 3.0 / 16, 1.0 / 6};
  std::size_t growing = 0;
  for (std::size_t i = 0; i < 3; ++i) growing += cell.low[i] != cell.high[i];
  Vec3 sum;
  for (std::size_t i = 0; i < 3; ++i)
    sum += cell.low[i] == cell.high[i] ? kStays[growing] * cell.low[i] : kGrows[growing] * (cell.low[i] + cell.high[i]);
  return sum;
}

double skewness(const CellSide& face, const Vec3& centre, const Vec3& other) {
  const SideMeasures measures = measure(face);
  const Vec3 way = other - centre, from = measures.centre - centre;
  const Vec3 off = from - dot(measures.area, from) / dot(measures.area, way) * way;
  double extent = 0.2 * norm(way);
  for (const Vec3& x : face) extent = std::max(extent, std::abs(dot(normalized(off), x - measures.centre)));
  return norm(off) / extent;
}

}  // namespace tetloom::layers
