#include "bench/support/stage_run.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bench/support/child_process.hpp"
#include "bench/support/machine.hpp"
#include "core/base/stopwatch.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::bench {
namespace {

/// Each stage's value at place `rank` of its sorted values.
StageSample pick_stages(const std::vector<StageSample>& samples, std::size_t rank) {
  StageSample picked = samples.front();
  const auto pick = [&](double StageSample::*seconds) {
    std::vector<double> values;
    for (const StageSample& sample : samples) values.push_back(sample.*seconds);
    std::sort(values.begin(), values.end());
    picked.*seconds = values[rank];
  };
  pick(&StageSample::read);
  for (const StageKind& stage : kStages) pick(stage.seconds);
  return picked;
}

}  // namespace

StageSample measure_stages_here(const StageTask& task) {
  Trace trace;
  MeshOptions options;
  options.sizes.size = task.size;
  options.threads = task.threads;
  options.tets_per_part = task.one_part ? HUGE_VAL : task.tets_per_part;
  options.trace = task.trace.empty() ? nullptr : &trace;
  StageSample sample;
  Stopwatch whole, stage;
  const ModelDocument document = read_model(task.model);
  sample.read = stage.lap();
  const MeshResult result = make_mesh(*document.model, options);
  if (result.status != MeshStatus::Ok) throw Error(result.errors.at(0));
  stage.lap();
  write_mesh(result.mesh, task.output);
  sample.write = stage.lap();
  sample.whole = whole.lap();
  sample.peak_bytes = peak_resident_bytes();
  sample.size_field = result.seconds.size_field;
  sample.surface = result.seconds.surface;
  sample.volume = result.seconds.volume;
  sample.tets = result.mesh.tet_to_vert.size();
  sample.digest = mesh_digest(result.mesh);
  std::filesystem::remove(task.output);
  if (options.trace != nullptr) trace.write(task.trace);
  return sample;
}

StageSample measure_stages_apart(const std::string& program, const StageTask& task) {
  const ChildResult child = run_child({program, "--measure", nlohmann::json(task).dump()});
  if (child.exit_status != 0) throw std::runtime_error("meshing '" + task.model + "' failed: " + child.output);
  return nlohmann::json::parse(child.output).get<StageSample>();
}

StageSample median_stages(const std::vector<StageSample>& samples) {
  return pick_stages(samples, (samples.size() - 1) / 2);
}

StageSample best_stages(const std::vector<StageSample>& samples) { return pick_stages(samples, 0); }

}  // namespace tetloom::bench
