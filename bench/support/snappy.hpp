#pragma once
// snappyHexMesh of OpenFOAM, run on the surface that tetloom has made, with the same layers asked for.
#include <cstdint>
#include <filesystem>
#include <string>

#include "tetloom/vec.hpp"

namespace tetloom::bench {

struct SnappyTask {
  std::filesystem::path surface;  ///< STL
  Vec3 low, high;                 ///< its bounding box
  Vec3 inside;                    ///< a point of the region
  double edge = 0;                ///< of the background's cubes
  double first_height = 0, growth = 1.2;
  int count = 0;
};

struct SnappySample {
  double seconds = 0;                        ///< of the whole run, its background mesh as well
  std::uint64_t cells = 0, layer_cells = 0;  ///< in the end; those added for layers
  double layers = 0, thickness = 0;          ///< mean number, and share of the thickness, as it says itself
  std::string failure;                       ///< what it said where it made no mesh
};

bool has_snappy();

/// Runs blockMesh and snappyHexMesh in `folder`, on one thread.
SnappySample run_snappy(const SnappyTask& task, const std::filesystem::path& folder);

/// Takes cells and layers from what it printed. Throws std::runtime_error where they are missing.
void read_snappy(const std::string& output, SnappySample& sample);

}  // namespace tetloom::bench
