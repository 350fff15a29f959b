#pragma once
// Skewness of the faces between cells of one layer, as OpenFOAM's checkMesh measures it.
#include <array>
#include <span>

#include "tetloom/vec.hpp"

namespace tetloom::layers {

/// The cell above a wall triangle between two fronts, where corners that do not grow are the same point in both: a
/// prism, a pyramid or a tet.
struct FrontCell {
  std::array<Vec3, 3> low, high;
};

/// A quadrilateral, or a triangle with one corner twice in a row; counter-clockwise seen from outside of a cell.
using CellSide = std::array<Vec3, 4>;

/// The centre of a cell as OpenFOAM has it: of the pyramids that its sides, at most six, make with the mean of their
/// centres.
Vec3 centre_of(std::span<const CellSide> sides);
Vec3 centre_of(const FrontCell& cell);
/// The centroid, if opposite edges were parallel.
Vec3 rough_centre_of(const FrontCell& cell);

/// How far the line between the centres of two cells misses the centre of the face between them, over how far the face
/// extends in that direction (at least a fifth of the way between the centres). checkMesh complains of 4.
double skewness(const CellSide& face, const Vec3& centre, const Vec3& other);

}  // namespace tetloom::layers
