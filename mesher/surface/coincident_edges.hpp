#pragma once
// Model edges that lie on each other: a line and an arc through the same two vertices that part by less than the
// model's tolerance, or one curve that is there twice. Private to the edge mesher.
#include <cstdint>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom {

/// That an edge lies on another one.
struct JoinedEdge {
  ModelEdgeId to;         ///< the edge whose nodes it shares, of lower number; the edge itself: it is joined to none
  bool reversed = false;  ///< the two run against each other
};

/// For every edge, the first one that it lies on: same vertices, and nowhere farther apart than the tolerances of the
/// two or `share` of the shorter one's length where `lone` says so for both (edges that will be a single piece).
/// Degenerate edges lie on none. Complexity: linear, apart from edges between the same two vertices.
std::vector<JoinedEdge> find_coincident_edges(const GeometricModel& model, const std::vector<bool>& lone);

}  // namespace tetloom
