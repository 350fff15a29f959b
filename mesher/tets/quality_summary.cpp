#include "mesher/tets/quality_summary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/tets/dihedral.hpp"
#include "mesher/tets/acute_tets.hpp"

namespace tetloom::tets {

namespace {

double radians(double degrees) { return degrees * 3.14159265358979323846 / 180; }

}  // namespace

// The mean comes from a histogram, as a root per tet would take longer than edge removal.
QualitySummary summarize(WorkingMesh& mesh, double goal) {
  constexpr std::size_t kBins = 8192;
  std::array<std::uint32_t, kBins + 1> histogram{};
  QualitySummary summary;
  float least = 1;
  const auto bound = static_cast<float>(cube(goal));
  const std::span<const float> qualities = mesh.qualities();
  for (std::size_t begin = 0, end = 0; begin < qualities.size(); begin = end) {
    const float quality = qualities[begin];  // tets of the lattice stand side by side and are alike
    while (end < qualities.size() && qualities[end] == quality) ++end;
    if (quality == WorkingMesh::kDeadQuality) continue;
    const auto alike = static_cast<std::uint32_t>(end - begin);
    least = std::min(least, quality);
    summary.below += quality < bound ? alike : 0;
    histogram[static_cast<std::size_t>(std::min(quality, 1.0f) * kBins)] += alike;
  }
  summary.least = std::cbrt(double{least});
  double count = 0;
  for (std::size_t bin = 0; bin <= kBins; ++bin) {
    if (histogram[bin] == 0) continue;
    summary.mean += histogram[bin] * std::cbrt((static_cast<double>(bin) + 0.5) / kBins);
    count += histogram[bin];
  }
  if (count > 0) summary.mean /= count;
  return summary;
}

double poor_quality(const QualityGoals& goals) {
  return std::min(std::max(largest_quality_with_dihedral(radians(goals.dihedral)), cube(goals.mean_ratio)), cube(.8));
}

void summarize_result(WorkingMesh& mesh, const QualityGoals& goals, OptimizeReport& report) {
  summarize_result(mesh, goals, dihedral_of_worst(mesh.mesh(), mesh.qualities()), report);
}

void summarize_result(WorkingMesh& mesh, const QualityGoals& goals, double known_least, OptimizeReport& report) {
  const QualitySummary after = summarize(mesh, goals.mean_ratio);
  report.least = after.least, report.mean = after.mean, report.below_goal = after.below;
  DihedralSummary angles = summarize_dihedrals(mesh, radians(goals.dihedral), known_least);
  report.least_dihedral = angles.least / radians(1);
  report.below_dihedral = angles.below, report.forced = angles.forced();
  report.forced_by_angles = angles.angles, report.forced_by_triangles = angles.triangles;
  report.forced_by_points = angles.points;
  report.acute_tets = std::move(angles.worst);
}

}  // namespace tetloom::tets
