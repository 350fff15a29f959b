#pragma once
// Edge removal: the tets around an edge are replaced by those over the best triangulation of the edge's ring.
//
// The triangulation whose worst tet is best is found by dynamic programming over sub-polygons (Klincsek 1980), pruned
// by what has to be beaten.
#include <cstdint>

#include "core/tets/edge_ring.hpp"
#include "core/tets/working_mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// What became of an edge that was to be removed.
enum class EdgeVerdict {
  Removed,
  OnSurface,    ///< a fixed face or nothing lies at the edge
  LongRing,     ///< more tets than pays: more than 5, or than kLongestRing where `tet` is very poor
  WorseBeside,  ///< another tet of the ring is worse: it is the one to ask
  NoGain        ///< no triangulation raises the minimum
};

inline constexpr int kLongestRing = 7;

/// The ring of edge `edge` (0 to 5) of `tet`; Removed when it may be removed, as far as its neighbours are concerned.
EdgeVerdict find_ring(const WorkingMesh& mesh, std::uint32_t tet, int edge, EdgeRing& ring);

/// The same however poor the others of the ring are, and for rings of up to kMostRingVerts; false where a fixed face
/// or nothing lies at the edge, or more tets.
bool find_any_ring(const WorkingMesh& mesh, std::uint32_t tet, int edge, EdgeRing& ring);

/// Removes, of the six edges of `tet`, the one whose removal raises the minimum of its ring most, where `tet` is the
/// worst of the ring. What is replaced and what replaces it have the same boundary; the new tets are positive in exact
/// arithmetic. Returns the verdict on the edge that came farthest.
EdgeVerdict remove_edge_of(WorkingMesh& mesh, std::uint32_t tet);

/// remove_edge_of for every tet of cubed quality below `limit` that is there at the start, in order of ids. Returns the
/// number of edges removed.
std::size_t remove_edges(WorkingMesh& mesh, double limit, const TaskRunner& runner);

}  // namespace tetloom::tets
