#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/console.hpp"
#include "apps/tetloom/mesh_text.hpp"
#include "apps/tetloom/parts_input.hpp"
#include "apps/tetloom/parts_text.hpp"
#include "apps/tetloom/quantities.hpp"
#include "apps/tetloom/run.hpp"
#include "core/io/mesh_io.hpp"
#include "core/mesh/digest.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/validate.hpp"
#include "threading/agreement.hpp"

namespace tetloom::app {
namespace {

using Json = nlohmann::ordered_json;

Json problem_json(const MeshProblem& problem) {
  Json json = {{"kind", to_string(problem.kind)}, {"element_kind", to_string(problem.element)},
               {"message", problem.message},      {"count", problem.count},
               {"elements", problem.elements},    {"point", nullptr}};
  if (problem.point) json["point"] = {problem.point->x, problem.point->y, problem.point->z};
  return json;
}

Json validation_json(const ValidationReport& validation) {
  Json problems = Json::array();
  for (const MeshProblem& problem : validation.problems) problems.push_back(problem_json(problem));
  return {{"valid", validation.valid()},
          {"problems", std::move(problems)},
          {"unused_points", validation.unused_points},
          {"unclassified_points", validation.unclassified_points},
          {"boundary_faces", validation.boundary_faces},
          {"interface_faces", validation.interface_faces},
          {"open_edges", validation.open_edges},
          {"nonmanifold_edges", validation.nonmanifold_edges}};
}

/// A problem of the mesh as an error of the run: exit status 4.
Diagnostic as_error(const MeshProblem& problem) {
  const bool boundary = problem.kind == ProblemKind::OpenBoundary;
  return {
      boundary ? ErrorCode::OpenShell : ErrorCode::VolumeFailed, problem.message, {}, problem.point, problem.elements};
}

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
void check_whole(const Mesh& mesh, const std::string& parts_text, Run& run) {
  RunReport& report = run.report();
  report.counts = {mesh.points.size(), mesh.tri_to_vert.size(), mesh.tet_to_vert.size(), 0};
  report.entities = mesh.entities;

  run.begin(Stage::Check);
  const ValidationReport validation = validate_mesh(mesh);
  report.extra["validation"] = validation_json(validation);
  for (const MeshProblem& problem : validation.problems) add_failure(report, as_error(problem));
  if (is_measurable(validation)) {
    run.begin(Stage::Check);
    report.quality = compute_quality(mesh);
    report.counts.regions = report.quality->cells.regions.size();
    report.digest = mesh_digest(mesh);
  }
  report.extra["mesh"] = mesh_json(mesh, report);
  run.set_text(render_mesh(mesh, report) + parts_text + verdict(validation, mesh));
}

void check_mesh(const CheckCommand& command, Run& run) {
  run.begin(Stage::Read);
  Mesh mesh;
  run.report().seconds.read =
      timed([&] { mesh = read_input([&] { return read_mesh(command.input, &run.cancel()); }); });
  check_whole(mesh, {}, run);
}

}  // namespace

ExitStatus run_check(const CheckCommand& command, Communicator& communicator) {
  Run run(
      {.input = command.input, .output = {}, .report = command.report, .quiet = command.quiet, .ranks = &communicator});
  return run.execute([&](Run& r) {
    if (const std::optional<WholeOfParts> whole = read_whole_of_parts(command.input, communicator, r))
      return run_on_first(communicator, [&] { check_whole(whole->mesh, render_parts(whole->figures), r); });
    run_on_first(communicator, [&] { check_mesh(command, r); });
  });
}

}  // namespace tetloom::app
