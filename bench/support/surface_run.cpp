#include "bench/support/surface_run.hpp"

#include <sys/resource.h>

#include <chrono>
#include <stdexcept>

#include "bench/support/child_process.hpp"
#include "bench/support/machine.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/surface/surface_mesher.hpp"
#include "tetloom/check.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::bench {
namespace {

/// Wall and processor time since it was made.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  double cpu_seconds() const { return process_cpu_seconds() - cpu_start_; }

 private:
  using Clock = std::chrono::steady_clock;
  static double process_cpu_seconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }

  Clock::time_point start_ = Clock::now();
  double cpu_start_ = process_cpu_seconds();
};

void test_intersections(const Mesh& mesh, const TaskRunner& runner, SurfaceSample& sample) {
  const Stopwatch watch;
  sample.intersections =
      find_self_intersections({.points = mesh.points, .tri_to_vert = mesh.tri_to_vert, .tri_to_group = {}}, runner)
          .size();
  sample.intersection_seconds = watch.seconds();
}

}  // namespace

void judge_mesh(const Mesh& mesh, double size, SurfaceSample& sample) {
  const SizeField sizes = SizeField::uniform(size);
  const TriangleQuality quality = compute_quality(mesh, &sizes).triangles;
  sample.triangles = quality.count;
  sample.quality = quality.shape_mean;
  sample.min_angle_deg = quality.min_angle_deg;
  sample.edge_ratio = quality.edges.mean_length_ratio;
  sample.in_band = quality.edges.in_band;
  sample.digest = mesh_digest(mesh);
}

SurfaceSample measure_here(const SurfaceTask& task) {
  const ModelDocument document = read_model(task.model);
  const SizeField sizes = SizeField::uniform(task.size);
  const TaskRunner runner(task.threads);
  SurfaceSample sample;
  const std::uint64_t resident = resident_bytes();
  const Stopwatch watch;
  const SurfaceMeshResult result = mesh_surface(*document.model, sizes, runner);
  sample.seconds = watch.seconds();
  sample.cpu_seconds = watch.cpu_seconds();
  sample.peak_bytes = peak_resident_bytes();
  sample.stage_bytes = sample.peak_bytes - resident;
  if (!result.errors.empty()) throw Error(result.errors.front());
  test_intersections(result.mesh, runner, sample);
  judge_mesh(result.mesh, task.size, sample);
  return sample;
}

SurfaceSample measure_apart(const std::string& program, const SurfaceTask& task) {
  const nlohmann::json request = {{"model", task.model.string()}, {"size", task.size}, {"threads", task.threads}};
  const ChildResult child = run_child({program, "--measure", request.dump()});
  if (child.exit_status != 0) {
    throw std::runtime_error("meshing '" + task.model.string() + "' failed: " + child.output);
  }
  return nlohmann::json::parse(child.output).get<SurfaceSample>();
}

}  // namespace tetloom::bench
