#pragma once
// adapt_mesh by several ranks together, and for results in parts.
#include <functional>
#include <optional>

#include "adapt/adapt.hpp"
#include "threading/communicator.hpp"
#include "threading/partitioned_mesh.hpp"

namespace tetloom {

/// As adapt_mesh, by all ranks together: parts of the mesh are dealt to them anew for every round. All of them give the
/// same mesh, metric and options, and keep that mesh whole. What comes out is the mesh of one process, bit for bit, on
/// rank 0, and an empty one on the others; all else in the result is the same on all ranks, but for the time.
///
/// A collective call. Errors: also InvalidArgument, where ranks give different meshes, metrics or options; what happens
/// to one rank, its host's wish to stop too, is the same error on all of them. Thread safety: one call for each
/// communicator.
AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const adapt::MetricField& metric, const AdaptOptions& options,
                                Communicator& ranks, const Host& host = {});
AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const std::function<adapt::Tensor(const Vec3&)>& metric,
                                const AdaptOptions& options, Communicator& ranks, const Host& host = {});

struct AdaptInPartsResult {
  AdaptResult run;                      ///< as of adapt_mesh_on_ranks, without the mesh
  std::optional<PartitionedMesh> mesh;  ///< when the run's status is Ok
  double partition_seconds = 0;         ///< of dealing the mesh to parts
};

/// The same mesh in `options.parts` parts of equal numbers of tets, for the next solve. Global ids of vertices are
/// their numbers in the mesh of adapt_mesh. Rank 0 has the whole mesh before it is dealt. A collective call; errors as
/// above.
AdaptInPartsResult adapt_mesh_in_parts(const Mesh& mesh, const adapt::MetricField& metric, const AdaptOptions& options,
                                       Communicator& ranks, const Host& host = {});
AdaptInPartsResult adapt_mesh_in_parts(const Mesh& mesh, const std::function<adapt::Tensor(const Vec3&)>& metric,
                                       const AdaptOptions& options, Communicator& ranks, const Host& host = {});

}  // namespace tetloom
