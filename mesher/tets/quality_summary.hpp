#pragma once
// How good a mesh is, in figures.
#include "core/tets/working_mesh.hpp"
#include "mesher/tets/optimizer.hpp"

namespace tetloom::tets {

/// Mean ratios of all tets.
struct QualitySummary {
  double least = 1, mean = 0;
  std::size_t below = 0;
};

/// `goal` is the mean ratio asked for.
QualitySummary summarize(WorkingMesh& mesh, double goal);

/// The cubed quality below which a goal may be missed, as far as it makes sense to try.
double poor_quality(const QualityGoals& goals);

/// Writes down how good the mesh has become; the counts of what was done stay.
void summarize_result(WorkingMesh& mesh, const QualityGoals& goals, OptimizeReport& report);
/// The same for one of several meshes that are summarised together: `known_least` as for summarize_dihedrals.
void summarize_result(WorkingMesh& mesh, const QualityGoals& goals, double known_least, OptimizeReport& report);

}  // namespace tetloom::tets
