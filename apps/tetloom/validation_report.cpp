#include "apps/tetloom/validation_report.hpp"

#include "core/base/codec.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::app {
namespace {

using Json = nlohmann::ordered_json;

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

void note_validation(const PartitionedMesh& mesh, const PartsReport& fit, const PartsSummary& summary,
                     RunReport& report) {
  std::vector<Json> problems;
  const auto add = [&](const char* kind, const std::string& message, std::uint64_t count,
                       const std::optional<Vec3>& point) {
    problems.push_back({{"kind", kind},
                        {"element_kind", nullptr},
                        {"message", message},
                        {"count", count},
                        {"elements", Json::array()},
                        {"point", point_json(point)}});
    add_failure(report, {ErrorCode::VolumeFailed, message, {}, point, {}});
  };
  gather(
      *mesh.communicator,
      [&](MessageWriter& writer) {
        writer.put(std::uint64_t{fit.problems.size()});
        for (const PartProblem& problem : fit.problems) {
          put_text(writer, "part " + std::to_string(problem.part.value) + ": " + problem.message);
          writer.put(problem.count);
          writer.put(problem.point);
        }
      },
      [&](MessageReader& reader) {
        for (auto left = reader.get<std::uint64_t>(); left > 0; --left) {
          const std::string message = get_text(reader);
          const auto count = reader.get<std::uint64_t>();
          add("unfit_pieces", message, count, reader.get<std::optional<Vec3>>());
        }
      });
  if (const std::size_t count = summary.quality.cells.inverted; count > 0)
    add("non_positive_volume", "tets that are flat or inverted: " + std::to_string(count), count, {});
  report.extra["validation"] = {{"valid", problems.empty()},
                                {"problems", problems},
                                {"unused_points", 0},
                                {"unclassified_points", summary.unclassified_points}};
}

}  // namespace tetloom::app
