#pragma once
// Scaled Jacobians of cells that are no tets.
#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/storage.hpp"

namespace tetloom {

/// Over all pyramids, prisms and hexahedra; 1 without any.
struct CellJacobians {
  double least = 1;
  double p1 = 1;  ///< first percentile of the cells' least one, interpolated linearly
};

/// The least over the corners of a cell (`corners_of`) of the Jacobian there divided by the lengths of its three edges,
/// and by what a prism has that stands on an equilateral triangle. 1 at best, not positive where the cell is inverted.
/// `values`, which are replaced, are those of all cells.
CellJacobians measure_jacobians(const Mesh& mesh, const BlockLoop& loop, GrowingArray<float>& values);

}  // namespace tetloom
