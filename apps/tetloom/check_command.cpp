#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/console.hpp"
#include "apps/tetloom/mesh_text.hpp"
#include "apps/tetloom/parts_input.hpp"
#include "apps/tetloom/parts_text.hpp"
#include "apps/tetloom/quantities.hpp"
#include "apps/tetloom/run.hpp"
#include "apps/tetloom/validation_report.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::app {
namespace {

using Json = nlohmann::ordered_json;

/// Whether the arrays are sound enough to measure anything.
bool is_measurable(const ValidationReport& validation) {
  for (const MeshProblem& problem : validation.problems) {
    const bool broken = problem.kind == ProblemKind::ArrayLength || problem.kind == ProblemKind::IndexOutOfRange ||
                        problem.kind == ProblemKind::NonFinitePoint;
    if (broken) return false;
  }
  return true;
}

std::string verdict(const ValidationReport& validation, const Mesh& mesh) {
  if (!validation.valid()) {
    return "The mesh is NOT valid: " + std::to_string(validation.problems.size()) +
           (validation.problems.size() == 1 ? " kind of problem" : " kinds of problems") + ", see above.\n";
  }
  if (cell_count(mesh) > 0) return "The mesh is valid.\n";
  return validation.open_edges == 0
             ? "The surface is valid and closed.\n"
             : "The surface is valid; it is open at " + format_count(validation.open_edges) + " edges.\n";
}

/// `parts_text` describes the parts, where the mesh has some.
void check_whole(const Mesh& mesh, const std::string& parts_text, const TaskRunner& runner, Run& run) {
  RunReport& report = run.report();
  report.counts = {mesh.points.size(), mesh.tri_to_vert.size(), mesh.tet_to_vert.size(), 0};
  report.entities = mesh.entities;

  run.begin(Stage::Check);
  ValidationReport validation;
  report.seconds.check = timed([&] { validation = note_validation(mesh, runner, report); });
  if (is_measurable(validation)) {
    run.begin(Stage::Check);
    report.seconds.check += timed([&] {
      report.quality = compute_quality(mesh, nullptr, runner);
      report.digest = mesh_digest(mesh, runner);
    });
    report.counts.regions = report.quality->cells.regions.size();
  }
  report.extra["mesh"] = mesh_json(mesh, report);
  run.set_text(render_mesh(mesh, report) + parts_text + verdict(validation, mesh));
}

/// Pieces that do not fit together make no mesh that could be checked any further; it is not valid, like a whole one
/// that does not fit itself.
void tell_misfit(const WholeOfParts& parts, Run& run) {
  const Diagnostic& misfit = *parts.misfit;
  add_failure(run.report(), {ErrorCode::VolumeFailed, misfit.message, {}, misfit.point, {}});
  const Json problem = {{"kind", "unfit_pieces"},    {"element_kind", nullptr},
                        {"message", misfit.message}, {"count", 1},
                        {"elements", Json::array()}, {"point", point_json(misfit.point)}};
  run.report().extra["validation"] = {{"valid", false}, {"problems", Json::array({problem})}};
  run.set_text(render_parts(parts.figures) + "The mesh is NOT valid: its pieces do not fit together.\n");
}

void check_mesh(const CheckCommand& command, const TaskRunner& runner, Run& run) {
  run.begin(Stage::Read);
  Mesh mesh;
  run.report().seconds.read =
      timed([&] { mesh = read_input([&] { return read_mesh(command.input, &run.cancel()); }); });
  check_whole(mesh, {}, runner, run);
}

}  // namespace

ExitStatus run_check(const CheckCommand& command, Communicator& communicator) {
  Run run({.input = command.input,
           .output = {},
           .report = command.report,
           .quiet = command.quiet,
           .threads = TaskRunner(command.threads).threads(),
           .ranks = &communicator});
  return run.execute([&](Run& r) {
    const TaskRunner runner(command.threads, r.host());
    const std::optional<WholeOfParts> whole = read_whole_of_parts(command.input, r.ranks(), runner, r);
    if (whole && whole->misfit) return tell_misfit(*whole, r);
    run_on_first(r.ranks(), [&] {
      whole ? check_whole(whole->mesh, render_parts(whole->figures), runner, r) : check_mesh(command, runner, r);
    });
    // A mesh that is not valid is noticed by the first rank alone, and all end alike.
    r.report().status = static_cast<ExitStatus>(share_number(r.ranks(), static_cast<std::uint64_t>(r.report().status)));
  });
}

}  // namespace tetloom::app
