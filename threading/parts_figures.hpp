#pragma once
// How large the parts of a mesh are, and how much of them lies on part boundaries.
#include <cstdint>
#include <string>
#include <vector>

#include "threading/partitioned_mesh.hpp"

namespace tetloom {

/// Imbalance is the greatest value of a part over the mean, less one.
struct PartsFigures {
  struct Row {
    std::int64_t elements = 0, vertices = 0;
    std::int64_t shared_vertices = 0;  ///< those that other parts have too
    std::int64_t neighbours = 0;       ///< parts that it shares a face with
    double weight = 0;
  };
  std::vector<Row> parts;
  std::int64_t elements = 0, vertices = 0;  ///< of the whole mesh, each once
  std::int64_t cut_faces = 0;               ///< faces between parts, each once
  std::int64_t edges = 0;                   ///< of the graph of parts: pairs that share a face
  double element_imbalance = 0, vertex_imbalance = 0, weight_imbalance = 0;
};

/// Figures of all parts, the same on all ranks. Weights are the values of a cell field added up in the order of the
/// cells; without a name, each cell weighs 1. A collective call. Errors: InvalidArgument when the field is not there,
/// has more than one component or values that are not positive and finite.
PartsFigures measure_parts(const PartitionedMesh& mesh, const std::string& weights = {});

/// Throws the error that measure_parts would, on all ranks. A collective call.
void require_weights(const PartitionedMesh& mesh, const std::string& weights);

}  // namespace tetloom
