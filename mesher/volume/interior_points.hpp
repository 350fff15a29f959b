#pragma once
// Points inside a closed surface, as dense as a size field asks.
//
// They lie on body-centred cubic lattices, whose Delaunay tetrahedra are all alike and of mean ratio .95: one lattice
// per size, in steps of about 1.587 from the field's smallest size to its largest. A lattice of size h has its
// cubes 1.083 h wide, so that its mean edge is h. A point is left out where it is nearer than .55 of the local size to
// the surface, or nearer than .65 h to a point of a finer lattice. Lattices are shifted off the axes of symmetry and
// each point is moved by 1e-4 h, by a hash of its lattice index: exact lattices are full of cospherical points.
#include <span>
#include <vector>

#include "core/base/vec.hpp"
#include "core/geometry/model.hpp"
#include "core/sizing/size_field.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "threading/task_runner.hpp"

namespace tetloom::volume {

struct InteriorRequest {
  const intersection::TriangleTree* tree = nullptr;  ///< over the triangles below
  std::span<const FaceSides> tri_to_sides;
  Box3 box;  ///< of the surface
  const SizeField* sizes = nullptr;
};

/// The points, finest lattice first; they depend on the request alone. A point is inside when the surface around it
/// says that it is in a region, whichever. Pre: the boundary of every region is closed. Errors: Cancelled; OutOfMemory
/// when the field asks for more points than 32-bit ids can name.
std::vector<Vec3> make_interior_points(const InteriorRequest& request, const TaskRunner& runner);

}  // namespace tetloom::volume
