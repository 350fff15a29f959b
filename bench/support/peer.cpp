#include "bench/support/peer.hpp"

#include <cstdio>
#include <stdexcept>

#include "bench/support/child_process.hpp"
#include "tetloom/io.hpp"

namespace tetloom::bench {
namespace {

/// From "Info    : Done meshing 2D (Wall 5.70793s, CPU 2.24074s)".
void read_stage_time(const std::string& output, SurfaceSample& sample) {
  const std::size_t place = output.find("Done meshing 2D (");
  if (place == std::string::npos || std::sscanf(output.c_str() + place, "Done meshing 2D (Wall %lfs, CPU %lfs)",
                                                &sample.seconds, &sample.cpu_seconds) != 2) {
    throw std::runtime_error("gmsh does not say how long its 2D stage took: " + output);
  }
}

}  // namespace

std::string exact_text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.17g", value);
  return text;
}

double number_behind(const std::string& output, const std::string& label) {
  const std::size_t place = output.rfind(label);
  double value = 0;
  if (place == std::string::npos || std::sscanf(output.c_str() + place + label.size(), "%lf", &value) != 1)
    throw std::runtime_error("a peer does not say '" + label + "': ..." + output.substr(output.size() / 2));
  return value;
}

std::string gmsh_version() {
  if (!is_installed("gmsh")) return "";
  const std::string output = run_child({"gmsh", "--version"}).output;
  return output.substr(0, output.find_first_of("\r\n"));
}

SurfaceSample measure_gmsh(const SurfaceTask& task, const std::filesystem::path& folder) {
  const std::string size = exact_text(task.size);
  const std::filesystem::path mesh_path = folder / "gmsh.msh";
  std::filesystem::remove(mesh_path);
  const ChildResult child = run_child({"gmsh", task.model, "-2", "-nt", std::to_string(task.threads), "-bin", "-clmin",
                                       size, "-clmax", size, "-o", mesh_path});
  const std::size_t tail = child.output.size() > 1000 ? child.output.size() - 1000 : 0;
  if (child.exit_status != 0 || !std::filesystem::exists(mesh_path)) {
    throw std::runtime_error("gmsh failed: ..." + child.output.substr(tail));
  }
  SurfaceSample sample;
  read_stage_time(child.output, sample);
  sample.peak_bytes = child.peak_bytes;
  judge_mesh(read_mesh(mesh_path), task.size, sample);
  return sample;
}

}  // namespace tetloom::bench
