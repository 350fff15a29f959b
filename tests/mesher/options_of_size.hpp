#pragma once
// Options of meshes of one size.
#include "tests/mesher/worker.hpp"
#include "tetloom/mesh.hpp"

namespace tetloom::test_models {

inline MeshOptions options_of_size(double size, int threads = 2) {
  MeshOptions options;
  options.sizes.size = size;
  options.threads = threads;
  options.volume_worker = test::kWorker;
  return options;
}

}  // namespace tetloom::test_models
