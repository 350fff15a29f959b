// A program that has tetloom mesh a model for it: it shows progress in its own way, can stop the work, and gets every
// error as a value with the CAD entities and a point.
//
//   tetloom-host part.step part.vtu            meshes
//   tetloom-host part.step part.vtu 0.5        asks for a stop after half a second
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <string>
#include <thread>

#include <tetloom/io.hpp>
#include <tetloom/mesh.hpp>
#include <tetloom/model.hpp>

namespace {

/// Raises a token after a while, unless the work is done before.
class Alarm {
 public:
  Alarm(tetloom::CancelToken& token, double seconds) {
    thread_ = std::thread([this, &token, seconds] {
      std::unique_lock lock(mutex_);
      const bool done = changed_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return done_; });
      if (!done) token.cancel();
    });
  }
  ~Alarm() {
    {
      const std::lock_guard lock(mutex_);
      done_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
  std::thread thread_;
};

/// Called from any thread, but never by two at once; returning false would stop the work as well.
bool show_progress(const tetloom::ProgressEvent& event) {
  std::cerr << tetloom::to_string(event.stage) << ' ' << event.done;
  if (event.total > 0) std::cerr << " of " << event.total;
  std::cerr << '\n';
  return true;
}

void print_errors(const tetloom::MeshResult& result) {
  for (const tetloom::Diagnostic& error : result.errors) {
    std::cout << tetloom::to_string(error.code) << ": " << error.message;
    for (const tetloom::NamedEntity& entity : error.entities) std::cout << ", " << tetloom::describe(entity);
    if (error.point) std::cout << ", near " << error.point->x << ' ' << error.point->y << ' ' << error.point->z;
    std::cout << '\n';
  }
  // What was finished is handed back: the surface mesh when the volume could not be filled.
  std::cout << "finished before that: " << result.mesh.tri_to_vert.size() << " triangles\n";
}

int mesh_file(const std::string& input, const std::string& output, double stop_after) {
  const tetloom::ModelDocument document = tetloom::read_model(input);
  tetloom::MeshOptions options;
  options.sizes.relative_size = 1.0 / 50;
  options.sizes.curvature = 24;
  options.volume_worker = TETLOOM_WORKER;

  tetloom::CancelToken stop;
  const Alarm alarm(stop, stop_after);
  const tetloom::MeshResult result = tetloom::make_mesh(*document.model, options, {show_progress, &stop});
  if (result.status != tetloom::MeshStatus::Ok) {
    print_errors(result);
    return result.status == tetloom::MeshStatus::Cancelled ? 5 : 1;
  }
  tetloom::write_mesh(result.mesh, output);
  std::cout << result.mesh.tet_to_vert.size() << " tetrahedra written to " << output << '\n';
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: tetloom-host MODEL MESH [SECONDS]\n";
    return 2;
  }
  try {
    return mesh_file(argv[1], argv[2], argc > 3 ? std::atof(argv[3]) : 1e6);
  } catch (const tetloom::Error& error) {
    std::cout << tetloom::to_string(error.code()) << ": " << error.what() << '\n';
    return 1;
  }
}
