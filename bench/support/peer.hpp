#pragma once
// Gmsh, run beside tetloom on the same file, size and threads.
#include <filesystem>
#include <string>

#include "bench/support/surface_run.hpp"

namespace tetloom::bench {

/// A number that reads back as the same number.
std::string exact_text(double value);

/// The first number behind the last `label` of a peer's output. Throws std::runtime_error where there is none.
double number_behind(const std::string& output, const std::string& label);

/// "4.8.4"; empty when gmsh is not installed.
std::string gmsh_version();

/// Runs `gmsh MODEL -2 -nt T -bin -clmin H -clmax H` and reads back what it wrote into `folder`. The seconds are those
/// that gmsh reports for its own 2D stage; its 1D stage, reading and writing do not count.
/// Throws std::runtime_error with the end of its output when it fails.
SurfaceSample measure_gmsh(const SurfaceTask& task, const std::filesystem::path& folder);

}  // namespace tetloom::bench
