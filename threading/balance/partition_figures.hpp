#pragma once
// How good a partition is.
#include <cstdint>
#include <span>
#include <vector>

#include "threading/balance/part_boundaries.hpp"

namespace tetloom {

/// Imbalance is the greatest value of a part over the mean, less one.
struct PartitionFigures {
  std::vector<std::int64_t> elements, weights, vertices;  ///< by part; a vertex counts in each part that touches it
  std::vector<std::uint32_t> neighbours;                  ///< by part: parts that it shares a face with
  double element_imbalance = 0, weight_imbalance = 0, vertex_imbalance = 0;
  std::int64_t cut_faces = 0;  ///< each once
};

/// Measures the tets of one block. `tet_to_vert` may be empty; then so is `vertices`. Otherwise 4 per tet, all below
/// `vertex_count`. O(tets + vertices + parts). Errors: InvalidArgument as for smooth_part_boundaries.
PartitionFigures measure_partition(const TargetedTets& tets, std::span<const std::uint32_t> tet_to_vert = {},
                                   std::size_t vertex_count = 0);

}  // namespace tetloom
