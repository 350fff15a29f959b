#include "mesher/features/displacement.hpp"

#include <algorithm>

namespace tetloom::features {
namespace {

constexpr std::size_t kMostPoints = 12;

double farthest(std::span<const Vec3> points, const Vec3& place) {
  double most = 0;
  for (const Vec3& point : points) most = std::max(most, distance(point, place));
  return most;
}

}  // namespace

std::span<const Vec3> Displacement::points_of(std::uint32_t v) const {
  const auto record = records_.find(v);
  return record == records_.end() ? points_.subspan(v, 1) : std::span<const Vec3>(record->second.points);
}

std::vector<Vec3> Displacement::points_of_edge(std::uint32_t u, std::uint32_t v, double s) const {
  std::vector<Vec3> points;
  for (const Vec3& a : points_of(u))
    for (const Vec3& b : points_of(v)) points.push_back((1 - s) * a + s * b);
  return points;
}

double Displacement::beside(std::uint32_t v) const {
  const auto record = records_.find(v);
  return record == records_.end() ? 0 : record->second.beside;
}

double Displacement::from(std::uint32_t v, const Vec3& place) const {
  return std::max(beside(v), farthest(points_of(v), place));
}

double Displacement::from_edge(std::uint32_t u, std::uint32_t v, double s, const Vec3& place) const {
  return std::max({beside(u), beside(v), farthest(points_of_edge(u, v, s), place)});
}

void Displacement::add(std::uint32_t v, std::span<const Vec3> more, const Vec3& place) {
  Record& record = records_[v];
  if (record.points.empty()) record.points.push_back(points_[v]);
  record.points.insert(record.points.end(), more.begin(), more.end());
  std::ranges::stable_sort(record.points, std::ranges::greater{}, [&](const Vec3& p) { return distance(p, place); });
  if (record.points.size() > kMostPoints) record.points.resize(kMostPoints);
}

void Displacement::merge(std::uint32_t gone, std::uint32_t kept, const Vec3& place) {
  add(kept, points_of(gone), place);
  note(kept, beside(gone));
}

void Displacement::merge_edge(std::uint32_t u, std::uint32_t v, double s, std::uint32_t apex, const Vec3& place) {
  add(apex, points_of_edge(u, v, s), place);
  note(apex, std::max(beside(u), beside(v)));
}

void Displacement::note(std::uint32_t kept, double distance) {
  Record& record = records_[kept];
  if (record.points.empty()) record.points.push_back(points_[kept]);
  record.beside = std::max(record.beside, distance);
}

}  // namespace tetloom::features
