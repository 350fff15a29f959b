#pragma once
// Edge removal: the tets around an edge are replaced by those over the best triangulation of the edge's ring.
//
//            b
//          / | \           the ring r0, r1, ... of edge a-b, counter-clockwise seen from b; a triangulation of it
//        r0--|--r1  ...    with n - 2 triangles gives 2 (n - 2) tets in place of n
//          \ | /
//            a
//
// The triangulation whose worst tet is best is found by dynamic programming over sub-polygons (Klincsek 1980), pruned
// by what has to be beaten.
#include <array>
#include <cstdint>
#include <span>

#include "mesher/tets/working_mesh.hpp"
#include "threading/task_runner.hpp"

namespace tetloom::tets {

enum class EdgeVerdict {
  Removed,
  OnSurface,    ///< a fixed face or nothing lies at the edge
  LongRing,     ///< more tets than pays: more than 5, or than kLongestRing where `tet` is very poor
  WorseBeside,  ///< another tet of the ring is worse: it is the one to ask
  NoGain        ///< no triangulation raises the minimum
};

inline constexpr int kLongestRing = 7;
inline constexpr int kMostRingVerts = 12;  // that there is room for

/// The tets around the edge a-b: tet i is (a, b, verts[i], verts[i + 1]).
struct EdgeRing {
  std::uint32_t a, b;
  int count = 0;
  std::array<std::uint32_t, kMostRingVerts> verts, tets;

  std::span<const std::uint32_t> old() const { return {tets.data(), static_cast<std::size_t>(count)}; }
};

/// The ring of edge `edge` (0 to 5) of `tet`; Removed when it may be removed, as far as its neighbours are concerned.
EdgeVerdict find_ring(const WorkingMesh& mesh, std::uint32_t tet, int edge, EdgeRing& ring);

/// Removes, of the six edges of `tet`, the one whose removal raises the minimum of its ring most, where `tet` is the
/// worst of the ring. What is replaced and what replaces it have the same boundary; the new tets are positive in exact
/// arithmetic. Returns the verdict on the edge that came farthest.
EdgeVerdict remove_edge_of(WorkingMesh& mesh, std::uint32_t tet);

/// remove_edge_of for every tet of cubed quality below `limit` that is there at the start, in order of ids. Returns the
/// number of edges removed.
std::size_t remove_edges(WorkingMesh& mesh, double limit, const TaskRunner& runner);

}  // namespace tetloom::tets
