#pragma once
// How good a mesh is, in figures.
#include "mesher/tets/optimizer.hpp"
#include "mesher/tets/working_mesh.hpp"

namespace tetloom::tets {

struct QualitySummary {
  double least = 1, mean = 0;
  std::size_t below = 0;
};

/// `goal` as in OptimizeOptions.
QualitySummary summarize(WorkingMesh& mesh, double goal);

/// The cubed quality below which a dihedral angle may be smaller than asked for.
double poor_quality(const OptimizeOptions& options);

/// Writes down how good the mesh has become; the counts of what was done stay.
void summarize_result(WorkingMesh& mesh, const OptimizeOptions& options, OptimizeReport& report);

}  // namespace tetloom::tets
