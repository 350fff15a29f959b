#pragma once
// What is said of a mesh in parts as a whole, found where its parts lie.
#include <array>
#include <cstdint>
#include <string>

#include "tetloom/check.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// Figures of the whole mesh. What several parts have counts with its owner.
struct PartsSummary {
  std::uint64_t points = 0, triangles = 0, tets = 0;
  std::uint64_t unclassified_points = 0;
  std::string digest;     ///< mesh_digest of the whole mesh
  QualityReport quality;  ///< as compute_quality
};

/// With `sizes`, which may be null, edges are compared with them. The same on all ranks: digests are sums that commute,
/// other sums are those of parts, added up in the order of parts, percentiles are found among all values. A rank holds
/// no more beside its parts than a copy of one part for each thread, without fields, and 4 bytes per tet. A collective
/// call. Errors: OutOfMemory, Cancelled.
PartsSummary summarize_parts(const PartitionedMesh& mesh, const TaskRunner& runner, const SizeField* sizes = nullptr);

}  // namespace tetloom
