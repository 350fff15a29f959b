#include "bench/support/cube.hpp"

#include <fstream>
#include <stdexcept>

#include "bench/support/child_process.hpp"
#include "bench/support/peer.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

const char* const kCube =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
    "f 1 3 2\nf 1 4 3\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\nf 4 5 8\n";
constexpr double kCubeSize = 0.098;

}  // namespace

fs::path make_cube(const Session& session) {
  const fs::path model = session.folder() / "cube.obj", mesh = session.folder() / "cube.meshb";
  std::ofstream(model) << kCube;
  const ChildResult made =
      run_child({TETLOOM_COMMAND, "mesh", model, "-o", mesh, "--size", exact_text(kCubeSize), "--quiet"});
  if (made.exit_status != 0) throw std::runtime_error("cannot mesh the cube: " + made.output);
  return mesh;
}

}  // namespace tetloom::bench
