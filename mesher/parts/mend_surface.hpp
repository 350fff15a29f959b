#pragma once
// Triangles of the surface that are no faces of the shell: recovered in clusters, each by one part that asks the others
// for the points around.
//
// Most such triangles stand alone. A cluster's neighbourhood is triangulated once more, which gives the tets that the
// parts have, and the triangles are recovered in it; what has changed there is told to all: which tets are no more, and
// to each part those of its own that take their place. A cluster may reach through the whole model.
#include <array>
#include <span>
#include <vector>

#include "mesher/parts/part_state.hpp"
#include "mesher/parts/recovered_tets.hpp"
#include "mesher/parts/shell_steps.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// Missing triangles that are near each other.
struct Cluster {
  std::vector<std::uint32_t> triangles;  ///< of the complex, ascending
  Box3 box;                              ///< in which points are taken
  PartId part;                           ///< that recovers them
};

/// The clusters of missing triangles, by their lowest triangle. Pre: `missing` ascends.
std::vector<Cluster> make_clusters(const SharedInput& input, std::span<const std::uint32_t> missing);

/// A pure site next to a point of the shell.
struct PureSite {
  VertKey next_to;
  Vec3 point;
};

/// What there is around a cluster.
struct NearPoints {
  std::vector<ShellPoint> points;
  std::vector<PureSite> pure;  ///< next to these, and so inside of the core
};

/// Own points of the shell in the cluster's box.
NearPoints find_near_points(const SharedInput& input, const PartShell& shell, PartId part, const Cluster& cluster);

/// What recovering a cluster has changed.
struct RecoveredCluster {
  std::vector<TetKeys> removed;  ///< tets of the shell, each ascending
  RecoveredTets tets;
  bool recovered = false;  ///< false: a triangle is missing still
};

/// `around`: of all parts, in the cluster's box.
RecoveredCluster recover_cluster(const SharedInput& input, const Cluster& cluster, NearPoints around,
                                 const TaskRunner& runner);

}  // namespace tetloom::parts
