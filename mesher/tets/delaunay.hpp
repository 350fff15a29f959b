#pragma once
// The Delaunay tetrahedralisation of given points, by insertion one by one (Bowyer 1981, Watson 1981).
#include <cstdint>
#include <span>
#include <vector>

#include "core/tets/tet_mesh.hpp"
#include "tetloom/tasks.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// A vertex that lies exactly where another one does, which stands for both.
struct Duplicate {
  std::uint32_t vert, kept;
};

/// Beside the tets: what surrounds them, and points that coincide.
struct DelaunayResult {
  /// Vertices of the tetrahedron around everything: first_outer … first_outer + 3, appended to the points.
  std::uint32_t first_outer = 0;
  std::vector<Duplicate> duplicates;  ///< ascending in `vert`
};

/// Where several parts of a set of points are triangulated apart, what they have to agree on.
struct DelaunayFrame {
  Box3 box;                             ///< of all points: where the outer ones follow from; empty: of those given
  std::span<const std::uint64_t> keys;  ///< per point of the mesh, distinct: they break ties; empty: the ids do
};

/// Replaces the tets of `mesh` by the Delaunay tetrahedralisation of the points `verts` and of four points far outside,
/// whose tetrahedron encloses all and has nothing behind its faces. No tet is dead, no face fixed; regions are kNone.
///
/// Unique: where points are cospherical, ties are broken by raising vertices in the lifted space by infinitesimals of
/// which those of higher ids are infinitely larger (Devillers & Teillaud 2011, who order by coordinates), so that the
/// result does not depend on the order of insertion. No flat tets come of that.
/// Points are inserted along a Hilbert curve in rounds of growing size (the biased randomised insertion order of
/// Amenta, Choi & Rote 2003; the choice is a hash of the id), n log n in practice; 37 bytes per tet, 8 per point beside
/// it. Pre: coordinates finite, ids valid and distinct. Errors: Cancelled; OutOfMemory beyond 2^30 tets.
DelaunayResult make_delaunay(TetMesh& mesh, std::span<const std::uint32_t> verts, const TaskRunner& runner,
                             const DelaunayFrame& frame = {});

/// Inserts more points into such a mesh, which may have been given fixed faces and whose outer points may have been
/// dropped from `mesh.points` since; no face is fixed afterwards. `outer_before`: the outer vertices' first number in
/// `mesh.to_vert`. Pre: the frame is as it was, and has a box. Errors as above.
DelaunayResult extend_delaunay(TetMesh& mesh, std::uint32_t outer_before, std::span<const std::uint32_t> verts,
                               const TaskRunner& runner, const DelaunayFrame& frame);

}  // namespace tetloom::tets
