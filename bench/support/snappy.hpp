#pragma once
// snappyHexMesh of OpenFOAM, run on the surface that tetloom has made, with the same layers asked for.
#include <filesystem>

#include "bench/support/foam_output.hpp"
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

bool has_snappy();

/// Runs blockMesh and snappyHexMesh in `folder`, on one thread.
SnappySample run_snappy(const SnappyTask& task, const std::filesystem::path& folder);

}  // namespace tetloom::bench
