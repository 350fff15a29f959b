#pragma once
// Model edges cut into pieces of the size asked for: once per edge, whatever faces meet there.
#include <vector>

#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// The nodes of one edge, from the start to the end of its range, ends included.
struct EdgeMesh {
  std::vector<double> t;     ///< ascending
  std::vector<Vec3> points;  ///< the ends are the model vertices' own points
  ModelEdgeId joined_to;     ///< the edge that this one lies on, and whose nodes are its own; none: it has its own
  bool reversed = false;     ///< against that edge
};

/// How fine edges are cut.
struct EdgeMeshOptions {
  /// Per edge, how many times finer than the size field asks; empty: 1 everywhere.
  std::vector<double> finer;
};

/// Discretises every edge of the model, in parallel; the number of pieces is ∫ ds/h rounded, and pieces are equal in
/// units of the size. Degenerate edges get their two ends. Closed edges get at least three pieces, turning ones at
/// least one per 80°, and two edges with the same ends never both a single piece unless both are straight. Edges that
/// coincide within their tolerances, or as single pieces within a thousandth of their length, have the same nodes.
/// Errors: Cancelled; EdgeFailed where an edge cannot be evaluated, with the edge.
std::vector<EdgeMesh> mesh_edges(const GeometricModel& model, const SizeField& sizes, const EdgeMeshOptions& options,
                                 const TaskRunner& runner);

}  // namespace tetloom
