#pragma once
// Small geometric models with exact shapes, for tests that need no CAD kernel. They follow the conventions of
// tetloom/model.hpp to the letter: loops run with the face on their left seen from the tip of du x dv, a seam
// appears twice in its loop (first along its own direction, then against it with second_side), poles and apexes are
// degenerate edges, and every normal points out of its region.
//
// A tessellation holds the points of a seam twice, once for each side of the parameter domain, as CAD kernels do.
//
// Thread safety: as GeometricModel.
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom::test_models {

/// A solid with flat faces. `face_to_vert` are convex and planar rings, counter-clockwise seen from outside. Edges are
/// numbered in the order in which the rings first use them; their parameter is the arc length. With `solid` false the
/// faces are sheets that bound no region.
std::unique_ptr<GeometricModel> make_polyhedron(std::span<const Vec3> points,
                                                std::span<const std::vector<std::uint32_t>> face_to_vert,
                                                bool solid = true);

/// The unit cube with the edge at x = 1, z = 1 cut off: face 4, as wide as `width`.
std::unique_ptr<GeometricModel> make_chamfered_cube(double width);

/// 6 faces (x lo, x hi, y lo, y hi, z lo, z hi), 12 edges, 8 vertices (bit 0 of the index: x, 1: y, 2: z), 1 region.
std::unique_ptr<GeometricModel> make_box(const Vec3& lo, const Vec3& hi);

/// A sheet [0, width] x [0, depth] at z = 0 whose normal is +z: 1 face, 4 edges, 4 vertices, no region.
std::unique_ptr<GeometricModel> make_plate(double width, double depth);

/// A flat sheet around the origin between two circles: 1 face with two loops, 2 closed edges, 2 vertices, no region.
std::unique_ptr<GeometricModel> make_annulus(double inner_radius, double outer_radius);

/// Around the z axis from z = 0 to `height`. Faces: side, bottom, top. Edges: bottom circle, top circle, seam.
std::unique_ptr<GeometricModel> make_cylinder(double radius, double height);

/// Faces: side, bottom. Edges: base circle (z = 0), seam, the degenerate apex at z = `height`. Vertices: base, apex.
std::unique_ptr<GeometricModel> make_cone(double radius, double height);

/// 1 face; edges: seam (from the south to the north pole), south pole, north pole; vertices: south, north.
std::unique_ptr<GeometricModel> make_sphere(const Vec3& center, double radius);

/// Around the z axis. 1 face; edges: outer equator (along u), tube circle (along v), both seams; 1 vertex.
/// Pre: minor_radius < major_radius.
std::unique_ptr<GeometricModel> make_torus(double major_radius, double minor_radius);

/// Several bodies side by side in one model; the ids of each follow those of the bodies before it.
std::unique_ptr<GeometricModel> combine(std::span<const std::shared_ptr<const GeometricModel>> bodies);

}  // namespace tetloom::test_models
