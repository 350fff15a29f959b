#include <algorithm>

#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/console.hpp"
#include "apps/tetloom/entity_sizes.hpp"
#include "apps/tetloom/mesh_report.hpp"
#include "apps/tetloom/parts_text.hpp"
#include "apps/tetloom/parts_whole.hpp"
#include "apps/tetloom/run.hpp"
#include "core/io/mesh_io.hpp"
#include "mesher/mesh_in_parts.hpp"
#include "threading/parts_io.hpp"

namespace tetloom::app {
namespace {

struct Sized {
  ModelDocument document;
  MeshOptions options;
};

Sized read_sized_model(const MeshCommand& command, Run& run) {
  RunReport& report = run.report();
  SizesFile sizes;
  if (!command.sizes_file.empty()) sizes = read_sizes(command.sizes_file);
  run.begin(Stage::Read);
  Sized sized{{}, command.options};
  report.seconds.read = timed(
      [&] { sized.document = read_input([&] { return read_model(command.input, command.read, &run.cancel()); }); });
  report.warnings = sized.document.warnings;
  apply_sizes(sizes, *sized.document.model, sized.options.sizes);
  return sized;
}

void check(const MeshResult& result, const TaskRunner& runner, Run& run) {
  RunReport& report = run.report();
  if (report.status == ExitStatus::Cancelled) return;
  run.begin(Stage::Check);
  report.seconds.check = timed([&] { measure_mesh(result.mesh, result.sizes, runner, report); });
}

void mesh_model(const MeshCommand& command, Run& run) {
  const auto [document, options] = read_sized_model(command, run);
  RunReport& report = run.report();
  const MeshResult result = make_mesh(*document.model, options, run.host());
  note_run(result, *document.model, options, report);
  if (!result.mesh.tet_to_vert.empty()) note_filling(result.filling, options.goals, report);
  const TaskRunner runner(options.threads, run.host());
  check(result, runner, run);
  if (result.status != MeshStatus::Ok) return;

  run.begin(Stage::Write);
  report.seconds.write = timed([&] { write_mesh(result.mesh, command.output, &run.cancel(), runner); });
  run.set_text(render_summary(report, command.output.string(), command.report.string()));
}

void mesh_model_in_parts(const MeshCommand& command, Communicator& communicator, Run& run) {
  const auto [document, options] = read_sized_model(command, run);
  RunReport& report = run.report();
  const MeshInPartsResult result = make_mesh_in_parts(*document.model, options, communicator, run.host());
  note_run(result.run, *document.model, options, report);
  const TaskRunner runner(options.threads, run.host());
  if (!result.mesh) return check(result.run, runner, run);

  note_filling(result.run.filling, options.goals, report);
  run.begin(Stage::Check);
  PartsFigures figures;
  report.parts = static_cast<int>(result.mesh->part_count());
  report.counts.regions = document.model->topology().region_count();
  report.seconds.check = timed([&] {
    figures = measure_parts(*result.mesh);
    note_whole(*result.mesh, figures, runner, report,
               [&](const Mesh& whole) { report.quality = compute_quality(whole, &result.run.sizes, runner); });
  });
  report.extra["partition"] = parts_json(figures);
  report.extra["partition"]["seconds"] = result.partition_seconds;

  run.begin(Stage::Write);
  report.seconds.write = timed([&] { write_parts(*result.mesh, command.output, runner, &run.cancel()); });
  run.set_text(render_summary(report, command.output.string(), command.report.string()) + render_parts(figures));
}

}  // namespace

ExitStatus run_mesh(const MeshCommand& command) {
  Run run({.input = command.input,
           .output = command.output,
           .report = command.report,
           .quiet = command.quiet,
           .threads = TaskRunner(command.options.threads).threads(),
           .parts = std::max(1, command.options.parts)});
  const auto communicator = make_thread_communicator();
  return run.execute(
      [&](Run& r) { command.in_parts ? mesh_model_in_parts(command, *communicator, r) : mesh_model(command, r); });
}

}  // namespace tetloom::app
