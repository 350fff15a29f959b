#pragma once
// Runs tetloom and Gmsh on one real model, each in a process of its own, and judges what they write.
#include <filesystem>
#include <string>

#include "bench/support/real_model.hpp"

namespace tetloom::bench {

struct RealRunOptions {
  double relative_size = 0.025;  ///< share of the bounding box's diagonal
  double curvature = 24;         ///< edges per full turn
  int threads = 2;
  double timeout = 120;  ///< seconds that each mesher may take
  bool no_peer = false;
  bool distance = false;  ///< measure how far tetloom's surface lies from the model, which is read once more for it
  std::string command;    ///< the `tetloom` to run
  std::string options;    ///< more of its options, with blanks between them
  std::string judge;      ///< this bench, which judges meshes in a process of its own (see judge_mesh_file)
  std::filesystem::path folder = {};  ///< where they write
};

/// Runs both. Never throws for what a mesher does or a model is: that is part of the result.
RealModel run_real_model(const std::filesystem::path& path, const RealRunOptions& options);

/// What a judging process is asked for.
struct JudgeTask {
  std::filesystem::path mesh;
  bool lenient = false;              ///< regions that are inside out as a whole are turned, as some meshers write them
  std::filesystem::path model = {};  ///< whose distance from the surface is measured; empty: none
  nlohmann::json report = {};        ///< of the run that made the mesh, for the solids that it has made anew
};
void to_json(nlohmann::json& json, const JudgeTask& task);
void from_json(const nlohmann::json& json, JudgeTask& task);

/// What it prints. Throws Error for what cannot be read.
MeshFigures judge_mesh_file(const JudgeTask& task);

}  // namespace tetloom::bench
