#pragma once
// Options of meshes of one size.
#include "tetloom/mesh.hpp"

namespace tetloom::test_models {

inline MeshOptions options_of_size(double size, int threads = 2) {
  MeshOptions options;
  options.sizes.size = size;
  options.threads = threads;
#ifdef TETLOOM_WORKER
  options.volume_worker = TETLOOM_WORKER;
#endif
  return options;
}

}  // namespace tetloom::test_models
