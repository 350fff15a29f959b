#pragma once
// Filling surfaces with the worker of the build.
#include "tests/mesher/volume_surfaces.hpp"
#include "tests/mesher/worker.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume_tests {

inline VolumeMesh fill(const Surface& surface, double size, int threads = 2) {
  const SizeField sizes = SizeField::uniform(size);
  return fill_volume(surface.input(sizes), {test::kWorker}, TaskRunner(threads));
}

}  // namespace tetloom::volume_tests
