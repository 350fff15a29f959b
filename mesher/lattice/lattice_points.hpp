#pragma once
// Which lattice points fill a closed surface, as dense as a size field asks.
//
// Where the field calls for a level, the points of that level's lattice are taken. A point is left out where it is
// nearer than about .55 of its lattice's size to the surface, or nearer than .65 of it to a point of a finer level.
#include <span>
#include <vector>

#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/lattice/site_lattice.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::lattice {

/// The surface, the sizes and the lattice that points are asked for.
struct LatticeRequest {
  const intersection::TriangleTree* tree = nullptr;  ///< over the triangles below
  std::span<const FaceSides> tri_to_sides;
  Box3 box;  ///< of the surface
  const SizeField* sizes = nullptr;
  LatticeKind kind = LatticeKind::Bcc;
  int attempt = 0;  ///< each has its own place of the lattices
};

/// The points of one level.
struct LevelPoints {
  SiteLattice lattice;
  std::vector<Site> sites;
  std::vector<char> near_surface;  ///< per site: too near for LatticeShape::near_surface()
  std::size_t foreign = 0;         ///< the last so many sites are known, but other parts': no tets are made of them
};

/// Finest level first; the points depend on the request alone. A point is inside when the surface around it says that
/// it is in a region, whichever. Pre: the boundary of every region is closed. Errors: Cancelled; OutOfMemory when the
/// field asks for more points than 32-bit ids can name.
std::vector<LevelPoints> make_lattice_points(const LatticeRequest& request, const TaskRunner& runner);

}  // namespace tetloom::lattice
