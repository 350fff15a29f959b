#pragma once
// Meshes of boxes with every kind of cell and a full classification, for tests of whatever handles meshes.
#include "tetloom/mesh_data.hpp"

namespace tetloom::test {

/// A box of nx * ny * nz cubes of edge length `h` with its low corner in the origin.
struct BoxSpec {
  int nx = 1, ny = 1, nz = 1;
  bool two_regions = false;  ///< the plane in the middle of x, for even nx, is an interface between two regions
  unsigned seed = 0;         ///< 0 leaves the points in place; others move those inside of regions
  double jitter = 0.1;       ///< by at most so much in each direction, as a share of h
  double h = 1;
};

/// Six tets in each cube (Kuhn 1960), classified on the model of a box: 8 vertices, 12 edges and 6 faces, or 12, 20 and
/// 11 for two regions, numbered by where they first appear; region 0 lies at low x. With the triangles and the edges on
/// the model's faces and edges, and the sides of the faces.
Mesh make_tet_box(const BoxSpec& spec);
Mesh make_tet_box(int nx, int ny, int nz, unsigned seed = 0, bool two_regions = false);

/// The unit cube in n³ cubes, whose points inside are moved.
Mesh make_unit_cube(int n, bool two_regions = false);

/// All four kinds of cells, conforming, classified as in `make_tet_box`. From below: a layer of prisms that stand on
/// triangles, layers of tets, a layer with a point in the middle of each cube from which pyramids reach up to
/// quadrilaterals and tets to the rest, and a layer of hexes in which some cubes are prisms. The boundary has triangles
/// and quadrilaterals. Pre: nz >= 4.
Mesh make_mixed_box(const BoxSpec& spec);
Mesh make_mixed_box(int nx, int ny, int nz, unsigned seed = 0, bool two_regions = false);

}  // namespace tetloom::test
