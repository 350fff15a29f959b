#pragma once
// What every way of filling a complex starts from and ends with.
#include <array>
#include <cstdint>
#include <vector>

#include "core/tets/tet_mesh.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/tets/shell.hpp"
#include "mesher/volume/filling_progress.hpp"
#include "mesher/volume/surface_freedom.hpp"
#include "tetloom/tasks.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::volume {

/// The complex that is filled, and how.
struct FillingInput {
  const Complex& complex;
  const intersection::TriangleTree& tree;  ///< of the complex
  const SizeField& sizes;
  FillingProgress& progress;
  const VolumeOptions& options;
  const SurfaceFreedom* freedom = nullptr;  ///< null: the surface stays
  int attempt = 0;                          ///< another one has another place of the lattice
};

/// The tets of a complex, or why there are none.
struct FilledMesh {
  tets::TetMesh mesh;  ///< points: the complex's, then new ones; some may be used by no tet
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;  ///< the complex's triangles; empty: as they were
  FillingFigures figures;
  tets::Fault fault;  ///< any: what is in the way, and the mesh is unspecified
};

/// What the optimiser is to aim at, for a mesh of the whole complex.
tets::OptimizeOptions optimize_options(const FillingInput& input);

/// What is wrong with the volumes of the tets, looked at in exact arithmetic. Errors: Cancelled.
tets::Fault check_volumes(const tets::TetMesh& mesh, const TaskRunner& runner);

/// The last steps, once the mesh fills the complex: optimises it, with the surface where that is free, and looks at the
/// volume of every tet once more. Errors: Cancelled.
void finish_filling(FilledMesh& filled, const FillingInput& input, const TaskRunner& runner);

/// The tets as the only part of the complex, the points that no tet has left out. `filled` is emptied on the way, so
/// that the two are never there at once. Pre: no fault. Errors: Cancelled.
PartMesh to_part(FilledMesh&& filled, const Complex& complex, const TaskRunner& runner);

}  // namespace tetloom::volume
