#include "apps/tetloom/validation_report.hpp"

namespace tetloom::app {
namespace {

using Json = nlohmann::ordered_json;

Json point_json(const std::optional<Vec3>& point) { return point ? Json{point->x, point->y, point->z} : Json(nullptr); }

Json problem_json(const MeshProblem& problem) {
  return {{"kind", to_string(problem.kind)}, {"element_kind", to_string(problem.element)},
          {"message", problem.message},      {"count", problem.count},
          {"elements", problem.elements},    {"point", point_json(problem.point)}};
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

Diagnostic as_error(const MeshProblem& problem) {
  const bool boundary = problem.kind == ProblemKind::OpenBoundary;
  return {
      boundary ? ErrorCode::OpenShell : ErrorCode::VolumeFailed, problem.message, {}, problem.point, problem.elements};
}

}  // namespace

ValidationReport note_validation(const Mesh& mesh, const BlockLoop& loop, RunReport& report) {
  ValidationReport validation = validate_mesh(mesh, loop);
  report.extra["validation"] = validation_json(validation);
  for (const MeshProblem& problem : validation.problems) add_failure(report, as_error(problem));
  return validation;
}

}  // namespace tetloom::app
