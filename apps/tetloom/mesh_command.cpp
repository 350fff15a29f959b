#include <algorithm>

#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/console.hpp"
#include "apps/tetloom/entity_sizes.hpp"
#include "apps/tetloom/run.hpp"
#include "core/io/mesh_io.hpp"
#include "core/mesh/digest.hpp"

namespace tetloom::app {
namespace {

nlohmann::ordered_json parts_json(const FillingPartsFigures& parts) {
  nlohmann::ordered_json strips = nlohmann::ordered_json::array();
  for (const FillingPartsFigures::Strips& round : parts.strips)
    strips.push_back({{"waiting_vertices", round.waiting}, {"tets", round.tets}, {"moved_tets", round.moved}});
  nlohmann::ordered_json json = {{"parts", parts.parts},
                                 {"tets_asked_about", parts.asked},
                                 {"rounds_of_asking", parts.asking_rounds},
                                 {"strips", strips},
                                 {"given_up", parts.given_up}};
  if (parts.given_up > 0) json["given_up_why"] = parts.given_up_why;
  return json;
}

nlohmann::ordered_json filling_json(const FillingFigures& figures, const QualityGoals& goals) {
  const FillingFigures::Seconds& seconds = figures.seconds;
  const tets::OptimizeReport& optimizer = figures.optimizer;
  return {
      {"core_tets", figures.core_tets},
      {"shell_tets", figures.shell_tets},
      {"missing_triangles", figures.missing_triangles},
      {"recovery_points", figures.recovery_points},
      {"worker_complexes", figures.worker_complexes},
      {"parts", parts_json(figures.parts)},
      {"seconds",
       {{"points", seconds.points},
        {"core", seconds.core},
        {"delaunay", seconds.delaunay},
        {"recovery", seconds.recovery},
        {"join", seconds.join},
        {"optimize", seconds.optimize},
        {"surface", seconds.surface}}},
      {"goals", {{"min_dihedral_deg", goals.dihedral}, {"mean_ratio_min", goals.mean_ratio}, {"rounds", goals.rounds}}},
      {"optimizer",
       {{"edges_removed", optimizer.edges_removed},
        {"vertices_moved", optimizer.vertices_moved},
        {"vertices_removed", optimizer.vertices_removed},
        {"points_inserted", optimizer.points_inserted},
        {"surface_edges_swapped", optimizer.edges_swapped},
        {"surface_vertices_slid", optimizer.vertices_slid},
        {"below_goal", optimizer.below_goal},
        {"below_dihedral", optimizer.below_dihedral},
        {"forced", optimizer.forced}}},
      {"acute_tets", acute_tets_json(optimizer)}};
}

nlohmann::ordered_json refinement_json(const SurfaceRefinement& refinement) {
  return {{"rounds", refinement.rounds},
          {"narrow_places", refinement.narrow_places},
          {"crossings", refinement.crossings},
          {"smallest_size", refinement.smallest_size}};
}

void note_result(const MeshResult& result, const QualityGoals& goals, RunReport& report) {
  const Mesh& mesh = result.mesh;
  report.counts = {mesh.points.size(), mesh.tri_to_vert.size(), mesh.tet_to_vert.size(), 0};
  report.seconds.size_field = result.seconds.size_field;
  report.seconds.surface = result.seconds.surface;
  report.seconds.volume = result.seconds.volume;
  report.warnings.insert(report.warnings.end(), result.warnings.begin(), result.warnings.end());
  report.entities = mesh.entities;
  report.extra["refinement"] = refinement_json(result.refinement);
  report.goals = goals;
  report.optimizer = result.filling.optimizer;
  if (!mesh.tet_to_vert.empty()) report.extra["filling"] = filling_json(result.filling, goals);
}

void measure(const MeshResult& result, const TaskRunner& runner, RunReport& report) {
  if (result.mesh.points.empty()) return;
  report.quality = compute_quality(result.mesh, &result.sizes, runner);
  report.counts.regions = report.quality->cells.regions.size();
  report.digest = mesh_digest(result.mesh, runner);
}

void mesh_model(const MeshCommand& command, Run& run) {
  RunReport& report = run.report();
  SizesFile sizes;
  if (!command.sizes_file.empty()) sizes = read_sizes(command.sizes_file);

  run.begin(Stage::Read);
  ModelDocument document;
  report.seconds.read =
      timed([&] { document = read_input([&] { return read_model(command.input, command.read, &run.cancel()); }); });
  report.warnings = document.warnings;
  MeshOptions options = command.options;
  apply_sizes(sizes, *document.model, options.sizes);

  const MeshResult result = make_mesh(*document.model, options, run.host());
  note_result(result, options.goals, report);
  if (!options.surface_only && document.model->topology().region_count() > 0) {
    report.model_volume = result.model_volume;
  }
  for (const Diagnostic& error : result.errors) add_failure(report, error);
  const TaskRunner runner(options.threads, run.host());
  if (report.status != ExitStatus::Cancelled) {
    run.begin(Stage::Check);
    report.seconds.check = timed([&] { measure(result, runner, report); });
  }
  if (result.status != MeshStatus::Ok) return;

  run.begin(Stage::Write);
  report.seconds.write = timed([&] { write_mesh(result.mesh, command.output, &run.cancel(), runner); });
  run.set_text(render_summary(report, command.output.string(), command.report.string()));
}

}  // namespace

ExitStatus run_mesh(const MeshCommand& command) {
  Run run({.input = command.input,
           .output = command.output,
           .report = command.report,
           .quiet = command.quiet,
           .threads = TaskRunner(command.options.threads).threads(),
           .parts = std::max(1, command.options.parts)});
  return run.execute([&](Run& r) { mesh_model(command, r); });
}

}  // namespace tetloom::app
