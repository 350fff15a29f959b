#include "apps/tetloom/mesh_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "tetloom/check.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::app {
namespace {

nlohmann::ordered_json filling_parts_json(const FillingPartsFigures& parts) {
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
      {"parts", filling_parts_json(figures.parts)},
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
          {"left", refinement.left},
          {"smallest_size", refinement.smallest_size}};
}

nlohmann::ordered_json entity_json(ModelEntity entity, const GeometricModel& model) {
  nlohmann::ordered_json json = {{"dim", entity.dim}, {"id", entity.tag()}};
  if (const std::string& name = model.attributes(entity).name; !name.empty()) json["name"] = name;
  return json;
}

// "absorbed" names at most this many entities.
constexpr std::size_t kMostAbsorbed = 1000;

nlohmann::ordered_json small_features_json(const MeshResult& result, const GeometricModel& model) {
  nlohmann::ordered_json absorbed = nlohmann::ordered_json::array();
  std::array<std::size_t, 3> counts{};
  double largest = 0;
  for (const AbsorbedEntity& one : result.absorbed) {
    ++counts[one.entity.dim];
    largest = std::max(largest, one.distance);
    if (absorbed.size() < kMostAbsorbed)
      absorbed.push_back({{"entity", entity_json(one.entity, model)},
                          {"into", entity_json(one.into, model)},
                          {"distance", one.distance}});
  }
  return {{"vertices", counts[0]},
          {"edges", counts[1]},
          {"faces", counts[2]},
          {"largest_distance", largest},
          {"absorbed", absorbed}};
}

// "off_model" lists at most this many mid nodes.
constexpr std::size_t kMostOffModel = 1000;

nlohmann::ordered_json second_order_json(const SecondOrderFigures& figures, const GeometricModel& model) {
  nlohmann::ordered_json off_model = nlohmann::ordered_json::array();
  for (const OffModelNode& node : figures.off_model) {
    if (off_model.size() == kMostOffModel) break;
    off_model.push_back({{"entity", entity_json(node.entity, model)},
                         {"distance", std::isfinite(node.distance) ? nlohmann::ordered_json(node.distance) : nullptr},
                         {"point", {node.point.x, node.point.y, node.point.z}}});
  }
  return {{"mid_nodes", figures.mid_nodes}, {"curved", figures.curved},
          {"moved", figures.moved},         {"min_scaled_jacobian", figures.min_scaled_jacobian},
          {"invalid", figures.invalid},     {"off_model_count", figures.off_model.size()},
          {"off_model", off_model},         {"seconds", figures.seconds}};
}

nlohmann::ordered_json coverage_json(const LayerCoverage& coverage) {
  return {{"wall_area", coverage.area},
          {"full_count", coverage.full_count},
          {"at_least_one", coverage.at_least_one},
          {"thickness", coverage.thickness},
          {"first_height_within_10pct", coverage.first_height_within_10pct},
          {"first_height_error", coverage.first_height_error},
          {"growth_error", coverage.growth_error}};
}

// "limited" lists at most this many places.
constexpr std::size_t kMostLimited = 1000;

nlohmann::ordered_json layers_json(const LayerFigures& figures, const GeometricModel& model) {
  nlohmann::ordered_json json = {
      {"cells",
       {{"prisms", figures.prisms}, {"pyramids", figures.pyramids}, {"hexes", figures.hexes}, {"tets", figures.tets}}}};
  json.update(coverage_json(figures.coverage));
  json["fans"] = figures.fans;
  json["min_scaled_jacobian"] = figures.min_scaled_jacobian;
  json["scaled_jacobian_p1"] = figures.scaled_jacobian_p1;
  json["first_angle_p99_deg"] = figures.first_angle_p99;
  json["seconds"] = figures.seconds;
  nlohmann::ordered_json faces = nlohmann::ordered_json::array(), limited = faces;
  for (const FaceLayers& face : figures.by_face) {
    faces.push_back(entity_json(face.face, model));
    faces.back().update(coverage_json(face.coverage));
  }
  for (const LimitedLayers& place : figures.limited) {
    if (limited.size() == kMostLimited) break;
    limited.push_back({{"reason", to_string(place.reason)},
                       {"area", place.area},
                       {"uncovered", place.uncovered},
                       {"point", {place.point.x, place.point.y, place.point.z}},
                       {"entities", {entity_json(place.face, model)}}});
  }
  json["by_face"] = std::move(faces);
  json["limited"] = std::move(limited);
  return json;
}

}  // namespace

void note_run(const MeshResult& result, const GeometricModel& model, const MeshOptions& options, RunReport& report) {
  report.seconds.size_field = result.seconds.size_field;
  report.seconds.surface = result.seconds.surface;
  report.seconds.layers = result.seconds.layers;
  report.seconds.volume = result.seconds.volume;
  report.seconds.second_order = result.seconds.second_order;
  report.warnings.insert(report.warnings.end(), result.warnings.begin(), result.warnings.end());
  report.entities = result.mesh.entities;
  report.extra["refinement"] = refinement_json(result.refinement);
  report.extra["small_features"] = small_features_json(result, model);
  if (!options.layers.walls.empty()) report.extra["layers"] = layers_json(result.layers, model);
  if (options.order == 2) report.extra["second_order"] = second_order_json(result.second_order, model);
  report.goals = options.goals;
  report.optimizer = result.filling.optimizer;
  if (!options.surface_only && model.topology().region_count() > 0) report.model_volume = result.model_volume;
  for (const Diagnostic& error : result.errors) add_failure(report, error);
}

void note_rebuilt(std::span<const std::vector<ModelRegionId>> lists, RunReport& report) {
  nlohmann::ordered_json& all = report.extra["rebuilt"] = nlohmann::ordered_json::array();
  Diagnostic warning{ErrorCode::InputUnsuitable,
                     "solids were made anew from the space that they enclose; to adapt this "
                     "mesh to its model:",
                     {},
                     {},
                     {}};
  for (const std::vector<ModelRegionId>& solids : lists) {
    nlohmann::ordered_json& tags = all.emplace_back(nlohmann::ordered_json::array());
    std::string text;
    for (const ModelRegionId solid : solids) {
      tags.push_back(ModelEntity(solid).tag());
      text += (text.empty() ? "" : ",") + std::to_string(ModelEntity(solid).tag());
    }
    warning.message += " --rebuild " + text;
  }
  report.warnings.push_back(std::move(warning));
}

void note_filling(const FillingFigures& figures, const QualityGoals& goals, RunReport& report) {
  report.extra["filling"] = filling_json(figures, goals);
}

void measure_mesh(const Mesh& mesh, const SizeField& sizes, const TaskRunner& runner, RunReport& report) {
  report.counts = {mesh.points.size(), mesh.tri_to_vert.size(), mesh.tet_to_vert.size(), 0};
  if (mesh.points.empty()) return;
  report.quality = compute_quality(mesh, &sizes, runner);
  report.counts.regions = report.quality->cells.regions.size();
  report.digest = mesh_digest(mesh, runner);
}

}  // namespace tetloom::app
