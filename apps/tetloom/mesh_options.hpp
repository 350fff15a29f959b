#pragma once
// The command line of `mesh`.
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/tetloom/options.hpp"
#include "apps/tetloom/reading_options.hpp"

namespace tetloom::app {

/// Values as they come from the command line, before they are judged.
struct RawMeshOptions {
  std::optional<double> size, relative_size, min_size, curvature, proximity, gradation;
  std::optional<double> min_dihedral, min_mean_ratio, tets_per_part, small_feature, min_scaled_jacobian, first_height,
      growth, layer_thickness, fan_angle, far_field;
  std::optional<int> threads, parts, rounds, order, layer_count;
  std::string input, output, sizes_file, report, worker, max_memory, lattice = "bcc", refinement, unit, msh_version,
                                                                     groups_file, layers;
  std::vector<std::string> groups;
  RawReading reading;
  bool surface_only = false, keep_small_features = false, no_refinement = false, keep_surface = false,
       keep_going = false, quiet = false, tetgen = false, ascii = false, all_tets = false;
};

CLI::App* add_mesh_command(CLI::App& app, RawMeshOptions& raw);

/// Throws UsageError.
MeshCommand make_mesh_command(const RawMeshOptions& raw);

}  // namespace tetloom::app
