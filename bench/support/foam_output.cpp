#include "bench/support/foam_output.hpp"

#include <regex>
#include <sstream>
#include <stdexcept>

namespace tetloom::bench {

FoamCheck read_check_mesh(const std::string& output) {
  static const std::regex faces("^\\s+faces:\\s+(\\d+)"), severe("severely non-orthogonal.*faces: (\\d+)"),
      skew("[Mm]ax skewness = ([0-9.eE+-]+)");
  FoamCheck check;
  double all = 0;
  std::istringstream lines(output);
  std::smatch found;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_search(line, found, faces)) all = std::stod(found[1]);
    if (std::regex_search(line, found, severe) && all > 0) check.non_orthogonal = std::stod(found[1]) / all;
    if (std::regex_search(line, found, skew)) check.skewness = std::stod(found[1]);
    // "***" begins what it calls an error.
    const std::size_t error = line.find("***");
    if (error == std::string::npos || line.find("aspect ratio") != std::string::npos) continue;
    check.is_fine = false;
    if (check.complaint.empty()) check.complaint = line.substr(error + 3);
  }
  return check;
}

void read_snappy(const std::string& output, SnappySample& sample) {
  const auto cells_of = [&](const std::string& mesh) {
    std::smatch found;
    if (!std::regex_search(output, found, std::regex(mesh + " mesh : cells:(\\d+)")))
      throw std::runtime_error("snappyHexMesh does not say how many cells its mesh has");
    return std::stoull(found[1]);
  };
  sample.cells = cells_of("Layer");
  sample.layer_cells = sample.cells - cells_of("Snapped");
  // The last table: patch, faces, layers, thickness, and its share in percent.
  static const std::regex row("\n\\s*wall\\s+\\d+\\s+([0-9.eE+-]+)\\s+[0-9.eE+-]+\\s+([0-9.eE+-]+)");
  for (std::sregex_iterator at(output.begin(), output.end(), row), end; at != end; ++at) {
    sample.layers = std::stod((*at)[1]);
    sample.thickness = std::stod((*at)[2]) / 100;
  }
}

}  // namespace tetloom::bench
