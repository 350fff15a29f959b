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

void optimize_inside(const SharedInput& input, PartState& state, PartId part, const TaskRunner& runner) {
  Stopwatch watch;
  tets::OptimizeOptions options = options_of(input, state.surface_count());
  options.open_faces = state.core.open_faces;
  if (input.filling.options.lattice == LatticeKind::Bcc)
    options.lattice_tets = static_cast<std::uint32_t>(state.figures.core_tets);
  options.qualities = &state.qualities;
  state.figures.optimizer = optimize(state.mesh, options, runner);
  while (state.keys.size() < state.mesh.points.size()) state.keys.push_back(key_of(part, state.next_index++));
  state.figures.seconds.optimize += watch.lap();
}

void optimize_strip(const SharedInput& input, Strip& strip, PartState& state, const TaskRunner& runner) {
  tets::OptimizeOptions options = options_of(input, strip.surface_count);
  options.qualities = &strip.qualities;
  tets::TetMesh& mesh = strip.mesh;
  count(optimize(mesh, options, runner), state.figures.optimizer);
  std::vector<char> is_outside(mesh.points.size(), 0);
  for (const FaceCode face : mesh.faces()) {
    if (mesh.behind(face).valid() || mesh.is_fixed(face)) continue;
    for (const std::uint32_t v : verts_of(mesh, face)) is_outside[v] = 1;
  }
  for (std::size_t v = 0; v < strip.waits.size(); ++v)
    if (!is_outside[v]) strip.waits[v] = 0;
}

void finish_part(const SharedInput& input, PartState& state, PartId part, const TaskRunner& runner) {
  Stopwatch watch;
  tets::OptimizeReport& report = state.figures.optimizer;
  const std::vector<std::uint32_t> dead =
      state.has_dead ? find_dead(state.qualities.span()) : std::vector<std::uint32_t>();
  {
    tets::WorkingMesh working(state.mesh, std::move(state.qualities));
    tets::summarize_result(working, input.filling.options.goals, state.known_least_angle, report);
  }
  compact(state.mesh, dead);
  report.tets = state.mesh.size();
  state.figures.seconds.optimize += watch.lap();
  const bool improved = wants_improvement(input, tets::cube(report.least));
  if (improved) improve_part(input, state, part, runner);
  state.figures.seconds.surface += watch.lap();
  // By their vertices in the complex.
  const auto to_complex = [&](std::uint32_t& v) { v = static_cast<std::uint32_t>(state.keys[v]); };
  for (AcuteTet& tet : report.acute_tets) {
    for (auto& triangle : tet.triangles) std::for_each(triangle.begin(), triangle.end(), to_complex);
    std::for_each(tet.points.begin(), tet.points.end(), to_complex);
  }
  // The qualities have proved it of all others. Those of the lattice are written down, not computed.
  if (improved || tets::cube(report.least) <= tets::kSurelyPositive)
    state.fault = volume::check_volumes(state.mesh, runner);
}

}  // namespace tetloom::parts
