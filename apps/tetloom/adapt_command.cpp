#include "apps/tetloom/adapt_input.hpp"
#include "apps/tetloom/adapt_report.hpp"
#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/run.hpp"
#include "apps/tetloom/validation_report.hpp"
#include "core/io/mesh_io.hpp"
#include "core/io/solution_io.hpp"
#include "core/mesh/digest.hpp"
#include "threading/agreement.hpp"

namespace tetloom::app {
namespace {

void note_mesh(const Mesh& mesh, const TaskRunner& runner, RunReport& report) {
  report.counts = {mesh.points.size(), mesh.tri_to_vert.size(), mesh.tet_to_vert.size(), 0};
  report.entities = mesh.entities;
  report.quality = compute_quality(mesh, nullptr, runner);
  report.counts.regions = report.quality->cells.regions.size();
  report.digest = mesh_digest(mesh, runner);
}

// The fields first: a mesh that is there has its fields beside it.
void write_output(const AdaptCommand& command, Mesh& mesh, const CancelToken& cancel, const TaskRunner& runner) {
  if (has_fields_beside(command.output) && !mesh.point_fields.empty())
    write_solution({mesh.point_fields, {}}, solution_size(mesh), fields_beside(command.output), &cancel, runner);
  write_mesh(mesh, command.output, &cancel, runner);
}

void adapt_input(const AdaptCommand& command, Run& run) {
  RunReport& report = run.report();
  run.begin(Stage::Read);
  AdaptInput input;
  report.seconds.read = timed([&] { input = read_input([&] { return read_adapt_input(command, run.cancel()); }); });
  report.warnings = input.document.warnings;

  const TaskRunner runner(command.options.threads, run.host());
  run.begin(Stage::SizeField);
  adapt::MetricField metric;
  const double metric_seconds = timed([&] { metric = make_metric(command, input, runner); });
  AdaptOptions options = command.options;
  options.model = input.document.model.get();
  options.gradation = command.hessian.gradation;
  AdaptResult result = adapt_mesh(input.mesh, metric, options, run.host());
  input.mesh = Mesh();
  report.parts = static_cast<int>(std::max<std::size_t>(1, result.report.most_parts));
  report.extra["adaptation"] = adaptation_json(result.report, metric_seconds);
  for (const Diagnostic& error : result.errors) add_failure(report, error);
  if (result.status != AdaptStatus::Ok) return;

  run.begin(Stage::Check);
  report.seconds.check = timed([&] {
    if (note_validation(result.mesh, runner, report).valid()) note_mesh(result.mesh, runner, report);
  });
  if (report.status != ExitStatus::Done) return;
  run.begin(Stage::Write);
  report.seconds.write = timed([&] { write_output(command, result.mesh, run.cancel(), runner); });
  run.set_text(render_adaptation(result.report, report, command.output.string(), command.report.string()));
}

}  // namespace

ExitStatus run_adapt(const AdaptCommand& command, Communicator& communicator) {
  Run run({.input = command.input,
           .output = command.output,
           .report = command.report,
           .quiet = command.quiet,
           .threads = TaskRunner(command.options.threads).threads(),
           .ranks = &communicator});
  return run.execute([&](Run& r) {
    run_on_first(communicator, [&] { adapt_input(command, r); });
    // What is found not to be valid is noticed by the first rank alone, and all end alike.
    r.report().status =
        static_cast<ExitStatus>(share_number(communicator, static_cast<std::uint64_t>(r.report().status)));
  });
}

}  // namespace tetloom::app
