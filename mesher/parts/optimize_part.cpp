#include "mesher/parts/optimize_part.hpp"

#include <algorithm>

#include "core/base/stopwatch.hpp"
#include "core/tets/many_values.hpp"
#include "core/tets/tet_quality.hpp"
#include "core/tets/triangle_verts.hpp"
#include "mesher/parts/improve_part.hpp"
#include "mesher/tets/quality_summary.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;

tets::OptimizeOptions options_of(const SharedInput& input, std::uint32_t surface_points) {
  tets::OptimizeOptions options = volume::optimize_options(input.filling);
  options.fixed_points = surface_points;
  options.keep_points = true;
  return options;
}

std::vector<std::uint32_t> find_dead(std::span<const float> qualities) {
  std::vector<std::uint32_t> dead;
  tets::for_each_that(
      0, qualities.size(), [=](std::size_t tet) { return qualities[tet] == tets::WorkingMesh::kDeadQuality; },
      [&](std::size_t tet) { dead.push_back(static_cast<std::uint32_t>(tet)); });
  return dead;
}

void count(const tets::OptimizeReport& done, tets::OptimizeReport& all) {
  for (const auto member : {&tets::OptimizeReport::edges_removed, &tets::OptimizeReport::vertices_moved,
                            &tets::OptimizeReport::points_inserted, &tets::OptimizeReport::vertices_removed})
    all.*member += done.*member;
}

}  // namespace

tets::OptimizeReport optimize_inside(const SharedInput& input, PartTets& tets, std::span<const FaceCode> open_faces,
                                     std::size_t core_tets, PartId part, const TaskRunner& runner) {
  tets::OptimizeOptions options = options_of(input, tets.surface_count);
  options.open_faces = open_faces;
  if (input.filling.options.lattice == LatticeKind::Bcc) options.lattice_tets = static_cast<std::uint32_t>(core_tets);
  options.qualities = &tets.qualities;
  tets::OptimizeReport report = optimize(tets.mesh, options, runner);
  while (tets.keys.size() < tets.mesh.points.size()) tets.keys.push_back(key_of(part, tets.next_index++));
  return report;
}

void optimize_strip(const SharedInput& input, KeyedTets& strip, tets::OptimizeReport& all, const TaskRunner& runner) {
  tets::OptimizeOptions options = options_of(input, strip.surface_count);
  options.qualities = &strip.qualities;
  tets::TetMesh& mesh = strip.mesh;
  count(optimize(mesh, options, runner), all);
  std::vector<char> is_outside(mesh.points.size(), 0);
  for (const FaceCode face : mesh.faces()) {
    if (mesh.behind(face).valid() || mesh.is_fixed(face)) continue;
    for (const std::uint32_t v : verts_of(mesh, face)) is_outside[v] = 1;
  }
  for (std::size_t v = 0; v < strip.waits.size(); ++v)
    if (!is_outside[v]) strip.waits[v] = 0;
}

FinishedSurface finish_part(const SharedInput& input, PartTets& tets, const BorderCheck& check, FillingFigures& figures,
                            PartId part, const TaskRunner& runner) {
  Stopwatch watch;
  FinishedSurface finished;
  tets::OptimizeReport& report = figures.optimizer;
  const std::vector<std::uint32_t> dead =
      tets.has_dead ? find_dead(tets.qualities.span()) : std::vector<std::uint32_t>();
  {
    tets::WorkingMesh working(tets.mesh, std::move(tets.qualities));
    tets::summarize_result(working, input.filling.options.goals, check.least_angle, report);
  }
  compact(tets.mesh, dead);
  report.tets = tets.mesh.size();
  figures.seconds.optimize += watch.lap();
  const bool improved = wants_improvement(input, tets::cube(report.least));
  if (improved) finished.changed_triangles = improve_part(input, tets, check.surface_elsewhere, report, part, runner);
  figures.seconds.surface += watch.lap();
  // By their vertices in the complex.
  const auto to_complex = [&](std::uint32_t& v) { v = static_cast<std::uint32_t>(tets.keys[v]); };
  for (AcuteTet& tet : report.acute_tets) {
    for (auto& triangle : tet.triangles) std::for_each(triangle.begin(), triangle.end(), to_complex);
    std::for_each(tet.points.begin(), tet.points.end(), to_complex);
  }
  // The qualities have proved it of all others. Those of the lattice are written down, not computed.
  if (improved || tets::cube(report.least) <= tets::kSurelyPositive)
    finished.fault = volume::check_volumes(tets.mesh, runner);
  return finished;
}

}  // namespace tetloom::parts
