#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/parts_text.hpp"
#include "apps/tetloom/quantities.hpp"
#include "apps/tetloom/rank_figures.hpp"
#include "apps/tetloom/run.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/parts_summary.hpp"

namespace tetloom::app {
namespace {

/// The partitioners want finite places, and each rank sees only its own.
void require_finite_points(const PartitionedMesh& mesh) {
  run_on_all(*mesh.communicator, [&] {
    for (const PartId part : mesh.local())
      for (const Vec3& p : mesh.parts.at(part).mesh.points)
        if (!is_finite(p)) throw Error(ErrorCode::InputUnsuitable, "the mesh has points that are not finite");
  });
}

void deal(const PartitionCommand& command, PartitionedMesh& mesh, const TaskRunner& runner) {
  require_finite_points(mesh);
  // In one part, Scotch cuts the mesh alike on any number of ranks.
  if (command.balance.method == PartitionMethod::Scotch && mesh.part_count() > 1) gather_in_one_part(mesh, runner);
  deal_cells(mesh, command.balance, runner);
}

std::string render_run(const PartitionCommand& command, const PartsFigures& figures, const RunReport& report) {
  std::string text = command.output.string() + ": " + format_count(figures.parts.size()) +
                     (figures.parts.size() == 1 ? " part, " : " parts, ") +
                     format_count(static_cast<std::uint64_t>(figures.elements)) + " elements, " +
                     format_count(static_cast<std::uint64_t>(figures.vertices)) + " vertices\n" + render_parts(figures);
  if (!report.digest.empty()) text += "  digest     " + report.digest + "\n";
  return text + "  time       " + format_seconds(report.total_seconds()) + " in all: read " +
         format_seconds(report.seconds.read) + ", write " + format_seconds(report.seconds.write) + "\n";
}

void partition(const PartitionCommand& command, Communicator& communicator, Run& run) {
  RunReport& report = run.report();
  const TaskRunner runner(command.threads, run.host());
  run.begin_together(Stage::Read);
  std::optional<PartitionedMesh> mesh;
  report.seconds.read =
      timed([&] { mesh = read_input([&] { return read_parts(command.input, communicator, runner, &run.cancel()); }); });
  run.begin_together(Stage::Partition);
  deal(command, *mesh, runner);
  run.begin_together(Stage::Check);
  const PartsFigures figures = measure_parts(*mesh, command.balance.weights);
  report.extra["partition"] = parts_json(figures);
  report.extra["partition"]["method"] = to_string(command.balance.method);
  const PartsSummary summary = summarize_parts(*mesh, runner);
  report.counts.points = summary.points, report.counts.triangles = summary.triangles;
  report.counts.tets = summary.tets;
  report.digest = summary.digest;
  run.begin_together(Stage::Write);
  report.seconds.write = timed([&] { write_parts(*mesh, command.output, runner, &run.cancel()); });
  run.set_text(render_run(command, figures, report));
  note_ranks(communicator, tets_of_rank(*mesh), nullptr, report);
}

}  // namespace

ExitStatus run_partition(const PartitionCommand& command, Communicator& communicator) {
  Run run({.input = command.input,
           .output = command.output,
           .report = command.report,
           .quiet = command.quiet,
           .threads = TaskRunner(command.threads).threads(),
           .parts = static_cast<int>(command.balance.part_count),
           .ranks = &communicator});
  return run.execute([&](Run& r) { partition(command, r.ranks(), r); });
}

}  // namespace tetloom::app
