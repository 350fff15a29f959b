#pragma once
// Growing layers on a surface mesh and writing them into a mesh, measured apart from all else.
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "bench/support/layer_run.hpp"

namespace tetloom::bench {

struct LayerStageTask {
  std::filesystem::path model;
  double edge = 0;  ///< target edge length
  double first_height = 0, growth = 1.2;
  int count = 0, threads = 1;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LayerStageTask, model, edge, first_height, growth, count, threads)

struct LayerStageSample {
  double grow = 0, write = 0;                      ///< seconds
  std::uint64_t cells = 0;                         ///< in layers
  std::uint64_t result_bytes = 0, peak_bytes = 0;  ///< of the layers in the mesh; beside what was there before
  std::string digest;

  double bytes_over_result() const {
    return (static_cast<double>(peak_bytes) - static_cast<double>(result_bytes)) / static_cast<double>(cells);
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(LayerStageSample, grow, write, cells, result_bytes, peak_bytes, digest)

/// Meshes the surface, grows layers on all faces that bound a region and makes a mesh of them, without the rest of the
/// volume. In this process. Throws Error.
LayerStageSample measure_layer_stage(const LayerStageTask& task);

}  // namespace tetloom::bench
