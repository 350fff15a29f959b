#pragma once
// From the tetrahedra around a surface to those of its regions: which lie where, and is everything as promised?
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/vec.hpp"
#include "mesher/volume/complex.hpp"
#include "mesher/volume/tet_faces.hpp"

namespace tetloom::volume {

/// Tetrahedra over the complex's points followed by new ones, to be judged.
struct Filling {
  std::vector<Vec3> points;  ///< the complex's points, then the new ones
  std::vector<TetVertices> tet_to_vert;
  std::vector<std::uint32_t> tet_to_region;
};

/// What is wrong with a filling; empty message: nothing.
struct FillingVerdict {
  std::string message;
  std::vector<std::uint32_t> triangles;  ///< of the complex, where they are the trouble
  Vec3 point;
  bool good() const { return message.empty(); }
};

/// Orients the tetrahedra, floods them up to the surface, names the region of each flood from the triangles around it
/// and drops those outside of every region and points that nothing uses any more. Leaves a filling that fulfils the
/// guarantees of fill_volume when the verdict is good; otherwise the filling is unspecified.
FillingVerdict color_regions(const Complex& complex, Filling& filling);

}  // namespace tetloom::volume
