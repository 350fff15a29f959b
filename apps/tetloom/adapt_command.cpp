#include <algorithm>
#include <optional>
#include <utility>

#include "apps/tetloom/adapt_input.hpp"
#include "apps/tetloom/adapt_report.hpp"
#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/model_reading.hpp"
#include "apps/tetloom/parts_text.hpp"
#include "apps/tetloom/parts_whole.hpp"
#include "apps/tetloom/rank_figures.hpp"
#include "apps/tetloom/run.hpp"
#include "apps/tetloom/validation_report.hpp"
#include "core/base/free_memory.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/comm/shared_work.hpp"
#include "threading/parts/parts_summary.hpp"

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
  if (has_fields_beside(command.output) && !(mesh.point_fields.empty() && mesh.cell_fields.empty()))
    write_solution({mesh.point_fields, mesh.cell_fields}, solution_size(mesh), fields_beside(command.output), &cancel,
                   runner);
  write_mesh(mesh, command.output, &cancel, runner);
}

// What is adapted, and to what.
struct AdaptTask {
  AdaptInput input;
  adapt::MetricField metric;
  PerPart<adapt::MetricField> metric_of_parts;  // of a mesh in parts, or else:
  std::optional<adapt::SolutionMetric> solution;
  double metric_seconds = 0;
};

// By all ranks together, which need not read all of the pieces each.
AdaptInput read_pieces(const AdaptCommand& command, Communicator& communicator, Run& run) {
  run.begin_together(Stage::Read);
  AdaptInput input;
  const SharedWork work(command.options.threads, run.host(), &communicator);
  run.report().seconds.read =
      timed([&] { input = read_input([&] { return read_pieces_of(command, work, run.cancel()); }); });
  if (input.parts) input.parts->communicator = &communicator;
  if (command.model.empty()) return input;
  const auto read_model_of_run = [&] {
    return read_on_ranks(command.model, command.read, command.options.threads, run.cancel(), communicator);
  };
  run.report().seconds.read += timed([&] { input.document = read_input(read_model_of_run); });
  return input;
}

void read_input_with_metric(const AdaptCommand& command, AdaptTask& task, Run& run) {
  const TaskRunner runner(command.options.threads, run.host());
  RunReport& report = run.report();
  run.begin(Stage::Read);
  report.seconds.read += timed([&] { read_input([&] { read_adapt_input(command, run.cancel(), task.input); }); });
  report.warnings = task.input.document.warnings;
  run.begin(Stage::SizeField);
  task.metric_seconds = timed([&] {
    if (task.input.parts && !command.hessian_field.empty())
      task.solution = {command.hessian_field, command.hessian};
    else if (task.input.parts)
      task.metric_of_parts = make_metric_of_parts(command, task.input, runner);
    else
      task.metric = make_metric(command, task.input, runner);
  });
}

AdaptOptions options_of(const AdaptCommand& command, const AdaptInput& input) {
  AdaptOptions options = command.options;
  options.model = input.document.model.get();
  options.gradation = command.hessian.gradation;
  if (command.curvature > 0) options.curvature = {command.curvature, command.hessian.bounds.h_min};
  return options;
}

// Whether there is a mesh; the same on all ranks.
bool note_run(const AdaptResult& result, double metric_seconds, RunReport& report) {
  report.parts = static_cast<int>(std::max<std::size_t>(1, result.report.most_parts));
  report.extra["adaptation"] = adaptation_json(result.report, metric_seconds);
  for (const Diagnostic& error : result.errors) add_failure(report, error);
  return result.status == AdaptStatus::Ok;
}

// By the first rank.
void finish_in_one_piece(const AdaptCommand& command, AdaptResult& result, const TaskRunner& runner, Run& run) {
  RunReport& report = run.report();
  run.begin(Stage::Check);
  report.seconds.check = timed([&] {
    if (note_validation(result.mesh, runner, report).valid()) note_mesh(result.mesh, runner, report);
  });
  if (report.status != ExitStatus::Done) return;
  run.begin(Stage::Write);
  report.seconds.write = timed([&] { write_output(command, result.mesh, run.cancel(), runner); });
  run.set_text(render_adaptation(result.report, report, command.output.string(), command.report.string()));
}

// What the first rank finds not to be valid, all know of.
void share_status(Communicator& communicator, RunReport& report) {
  report.status = static_cast<ExitStatus>(share_number(communicator, static_cast<std::uint64_t>(report.status)));
}

// What is checked where parts lie: that they fit together, and that all tets are positive.
void note_parts(PartitionedMesh& mesh, const PartsFigures& figures, const TaskRunner& runner, RunReport& report) {
  const PartsReport fit = validate_parts(mesh, runner);
  const PartsSummary summary = summarize_parts(mesh, runner);
  note_summary(summary, figures, report);
  note_validation(mesh, fit, summary, report);
}

// By all ranks.
void finish_in_parts(const AdaptCommand& command, AdaptInPartsResult& result, const GeometricModel* model,
                     const TaskRunner& runner, Run& run) {
  RunReport& report = run.report();
  run.begin_together(Stage::Check);
  PartsFigures figures;
  report.parts = static_cast<int>(result.mesh->part_count());
  report.seconds.check = timed([&] {
    figures = measure_parts(*result.mesh);
    note_parts(*result.mesh, figures, runner, report);
  });
  report.extra["partition"] = parts_json(figures);
  report.extra["partition"]["seconds"] = result.partition_seconds;
  if (model != nullptr) note_model_bytes(*result.mesh, *model, report.extra["partition"]);
  if (report.status != ExitStatus::Done) return;  // the same on all ranks
  run.begin_together(Stage::Write);
  report.seconds.write = timed([&] { write_parts(*result.mesh, command.output, runner, &run.cancel()); });
  run.set_text(render_adaptation(result.run.report, report, command.output.string(), command.report.string()) +
               render_parts(figures));
  note_ranks(*result.mesh->communicator, tets_of_rank(*result.mesh), model, report);
}

// Nothing is left of the mesh afterwards.
AdaptInPartsResult adapt_in_parts(AdaptTask& task, const AdaptOptions& options, Communicator& ranks, const Host& host) {
  AdaptInput& input = task.input;
  AdaptInPartsResult result =
      task.solution && input.parts ? adapt_mesh_in_parts(std::move(*input.parts), *task.solution, options, host)
      : input.parts ? adapt_mesh_in_parts(std::move(*input.parts), std::move(task.metric_of_parts), options, host)
                    : adapt_mesh_in_parts(std::move(*input.mesh), std::move(task.metric), options, ranks, host);
  input.parts.reset(), input.mesh.reset();
  return result;
}

AdaptResult adapt_on_ranks(AdaptTask& task, const AdaptOptions& options, Communicator& ranks, const Host& host) {
  AdaptInput& input = task.input;
  AdaptResult result =
      task.solution && input.parts ? adapt_mesh_on_ranks(std::move(*input.parts), *task.solution, options, host)
      : input.parts ? adapt_mesh_on_ranks(std::move(*input.parts), std::move(task.metric_of_parts), options, host)
                    : adapt_mesh_on_ranks(std::move(*input.mesh), std::move(task.metric), options, ranks, host);
  input.parts.reset(), input.mesh.reset();
  return result;
}

void adapt_input(const AdaptCommand& command, Communicator& communicator, Run& run) {
  if (communicator.rank_count() > 1) return_freed_memory();
  AdaptTask task;
  task.input = read_pieces(command, communicator, run);
  run_on_all(communicator, [&] { read_input_with_metric(command, task, run); });
  const AdaptOptions options = options_of(command, task.input);
  const TaskRunner runner(options.threads, run.host());
  if (command.in_parts) {
    AdaptInPartsResult result = adapt_in_parts(task, options, communicator, run.host());
    if (note_run(result.run, task.metric_seconds, run.report()))
      finish_in_parts(command, result, options.model, runner, run);
    return;
  }
  AdaptResult result = adapt_on_ranks(task, options, communicator, run.host());
  if (!note_run(result, task.metric_seconds, run.report())) return;
  run_on_first(communicator, [&] {
    finish_in_one_piece(command, result, runner.with_idle_threads(communicator.ranks_on_machine()), run);
  });
  share_status(communicator, run.report());
  note_ranks(communicator, result.mesh.tet_to_vert.size(), options.model, run.report());
}

}  // namespace

ExitStatus run_adapt(const AdaptCommand& command, Communicator& communicator) {
  Run run({.input = command.input,
           .output = command.output,
           .report = command.report,
           .quiet = command.quiet,
           .threads = TaskRunner(command.options.threads).threads(),
           .parts = std::max(1, command.options.parts),
           .ranks = &communicator});
  return run.execute([&](Run& r) { adapt_input(command, r.ranks(), r); });
}

}  // namespace tetloom::app
