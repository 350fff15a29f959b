#pragma once
// Runs `tetloom mesh --layers` on one model and judges what it writes.
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/support/foam_output.hpp"

namespace tetloom::bench {

/// Layers asked for on all walls, in mean edges.
struct LayerSetting {
  std::string name;
  double first_height = 0;  ///< of the mean edge
  int count = 0;
};

/// A: .05 × 8; B: .02 × 20; C: 10⁻⁴ × 42; each layer 1.2 times as high as the one below.
const std::vector<LayerSetting>& layer_settings();

struct LayerTask {
  std::filesystem::path model;
  LayerSetting setting;
  bool outside = false;         ///< the space around the model, in a box of three times its size
  double relative_size = 0.02;  ///< target edge, as a share of the model's diagonal
  double mean_edge = 0;         ///< what heights are shares of, in the model's unit; 0: the target edge
  int threads = 2;
  double timeout = 600;       ///< seconds of a run
  bool with_layers = true;    ///< false: the same mesh without, to compare
  bool by_check_mesh = true;  ///< judge by OpenFOAM as well
};

/// What a mesh with layers is by tetloom's own check, and by others.
struct LayerVerdict {
  std::string problem;  ///< the first that validate_mesh finds; empty: none
  std::uint64_t inverted = 0;
  double volume_error = 0;                 ///< relative, beside the model's volume
  std::optional<FoamCheck> by_check_mesh;  ///< none: not run

  bool is_valid() const { return problem.empty() && inverted == 0 && volume_error < 0.01; }
};

struct LayerRun {
  int exit_status = -1;
  bool timed_out = false;
  std::string failure;      ///< what it said when it made no mesh
  bool is_located = false;  ///< the failure names faces and a point
  double seconds = 0, cpu_seconds = 0, layer_seconds = 0;
  std::uint64_t peak_bytes = 0, cells = 0, layer_cells = 0;
  nlohmann::json layers;  ///< as in the report
  LayerVerdict verdict;
  std::string digest;

  bool made_mesh() const { return exit_status == 0; }
  double figure(const char* name) const { return layers.value(name, 0.0); }
};
nlohmann::json to_json(const LayerRun& run);

/// Runs and judges; never throws for what the mesher does. `judge` is this bench, which judges in a process of its own.
LayerRun run_layers(const LayerTask& task, const std::string& judge, const std::filesystem::path& folder);

/// The mean edge of the surface mesh that a task starts from; the target edge where it has none. Edges are shorter than
/// their target where curvature asks for it.
double mean_edge_of(const LayerTask& task, const std::filesystem::path& folder);

/// The target edge of a model in its own unit. Throws std::runtime_error for what is no model.
double edge_of(const std::filesystem::path& model, double relative_size);

/// What a judging process prints: validity, and the mesh once more as a case of OpenFOAM beside it.
nlohmann::json judge_layers(const std::filesystem::path& mesh);

}  // namespace tetloom::bench
