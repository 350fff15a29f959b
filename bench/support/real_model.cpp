#include "bench/support/real_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace tetloom::bench {
namespace {

using Json = nlohmann::json;

constexpr double kVolumeBound = 0.01;       // a mesh keeps the volume within this share
constexpr double kComparableVolume = 0.95;  // of a mesh that counts as one of the whole model
constexpr double kEmptyVolume = 1e-12;      // of a region that encloses nothing, beside the diagonal cubed

/// A number that may be missing or null.
double number_of(const Json& json, const char* key) {
  return json.is_object() && json.contains(key) && json.at(key).is_number() ? json.at(key).get<double>() : 0.0;
}

std::string text_of(const Json& json, const char* key) {
  return json.is_object() && json.contains(key) && json.at(key).is_string() ? json.at(key).get<std::string>() : "";
}

/// An object or array that may be missing.
Json child_of(const Json& json, const char* key) {
  return json.is_object() && json.contains(key) ? json.at(key) : Json();
}

std::string entities_text(const Json& entities) {
  std::string text;
  for (const Json& entity : entities) {
    const auto dim = static_cast<std::size_t>(number_of(entity, "dim"));
    if (dim > 3) continue;
    text += (text.empty() ? "" : ", ") + std::string(kEntityKinds[dim]) + ' ' +
            std::to_string(static_cast<long>(number_of(entity, "id")));
  }
  return text;
}

std::optional<WorstAngle> worst_angle(const Json& report) {
  std::optional<WorstAngle> worst;
  for (const Json& tet : child_of(child_of(child_of(report, "filling"), "acute_tets"), "worst")) {
    const double angle = number_of(tet, "dihedral_deg");
    if (worst && worst->dihedral_deg <= angle) continue;
    worst = {angle, number_of(tet, "cause_deg"), number_of(tet, "cause_length"), text_of(tet, "cause"),
             entities_text(child_of(tet, "entities"))};
  }
  return worst;
}

/// By how much a volume differs; one that should be nothing is not judged.
double volume_error(const MeshFigures& mesh, const ModelFacts& facts) {
  return facts.volume() > 0 ? mesh.volume / facts.volume() - 1 : 0;
}

std::string percent_text(double share) {
  char text[32];
  std::snprintf(text, sizeof(text), "%+.1f %%", 100 * share);
  return text;
}

/// What is wrong with a mesh; empty where nothing is.
std::string mesh_trouble(const MeshFigures& mesh, const ModelFacts& facts) {
  if (facts.volumes.empty()) {
    if (mesh.triangles == 0) return "no triangles";
  } else {
    if (mesh.tets == 0) return "no tets";
    if (mesh.inverted > 0) return std::to_string(mesh.inverted) + " inverted";
    if (mesh.regions < facts.good_regions())
      return std::to_string(mesh.regions) + " of " + std::to_string(facts.good_regions()) + " solids";
    if (std::abs(volume_error(mesh, facts)) > kVolumeBound) return "volume " + percent_text(volume_error(mesh, facts));
  }
  return "";
}

/// What is wrong with a run; empty where nothing is.
std::string run_trouble(const MesherRun& run, const ModelFacts& facts) {
  if (run.timed_out) return "too slow";
  if (run.exit_status != 0) return "exit " + std::to_string(run.exit_status);
  return run.mesh ? mesh_trouble(*run.mesh, facts) : "not judged";
}

Json run_json(const MesherRun& run) {
  Json json = {{"exit_status", run.exit_status},
               {"timed_out", run.timed_out},
               {"seconds", run.seconds},
               {"cpu_seconds", run.cpu_seconds},
               {"peak_bytes", run.peak_bytes},
               {"failure", run.failure},
               {"mesh", nullptr}};
  if (run.mesh) json["mesh"] = *run.mesh;
  return json;
}

}  // namespace

void to_json(Json& json, const MeshFigures& figures) {
  json = {{"tets", figures.tets},
          {"triangles", figures.triangles},
          {"inverted", figures.inverted},
          {"regions", figures.regions},
          {"volume", figures.volume},
          {"min_dihedral_deg", figures.min_dihedral_deg},
          {"ratio_mean", figures.ratio_mean},
          {"ratio_p1", figures.ratio_p1},
          {"ratio_min", figures.ratio_min},
          {"edges_in_band", figures.edges_in_band},
          {"surface_distance", nullptr},
          {"problem", figures.problem}};
  if (figures.surface_distance) json["surface_distance"] = *figures.surface_distance;
}

void from_json(const Json& json, MeshFigures& figures) {
  json.at("tets").get_to(figures.tets), json.at("triangles").get_to(figures.triangles);
  json.at("inverted").get_to(figures.inverted), json.at("regions").get_to(figures.regions);
  json.at("volume").get_to(figures.volume), json.at("min_dihedral_deg").get_to(figures.min_dihedral_deg);
  json.at("ratio_mean").get_to(figures.ratio_mean), json.at("ratio_p1").get_to(figures.ratio_p1);
  json.at("ratio_min").get_to(figures.ratio_min), json.at("edges_in_band").get_to(figures.edges_in_band);
  json.at("problem").get_to(figures.problem);
  if (json.at("surface_distance").is_number()) figures.surface_distance = json.at("surface_distance").get<double>();
}

double ModelFacts::volume() const { return std::accumulate(volumes.begin(), volumes.end(), 0.0); }

std::size_t ModelFacts::good_regions() const {
  const double bound = kEmptyVolume * diagonal * diagonal * diagonal;
  return static_cast<std::size_t>(
      std::count_if(volumes.begin(), volumes.end(), [&](double volume) { return volume > bound; }));
}

double MesherRun::tets_per_second() const {
  return mesh && seconds > 0 ? static_cast<double>(mesh->tets) / seconds : 0;
}

std::vector<std::vector<ModelRegionId>> rebuilt_solids(const Json& report) {
  std::vector<std::vector<ModelRegionId>> lists;
  for (const Json& tags : child_of(report, "rebuilt")) {
    lists.emplace_back();
    for (const Json& tag : tags) lists.back().push_back(ModelRegionId(tag.get<std::size_t>() - 1));
  }
  return lists;
}

void take_description(const Json& report, ModelFacts& facts) {
  const Json model = child_of(report, "model"), box = child_of(model, "bounding_box");
  if (box.is_array() && box.size() == 2) {
    double squares = 0;
    for (std::size_t i = 0; i < 3; ++i) squares += std::pow(box[1].at(i).get<double>() - box[0].at(i).get<double>(), 2);
    facts.diagonal = std::sqrt(squares);
  }
  facts.volumes.clear();
  for (const Json& region : child_of(model, "regions")) facts.volumes.push_back(number_of(region, "volume"));
}

void take_report(const Json& report, RealModel& model) {
  const Json seconds = child_of(report, "seconds");
  model.stages = {number_of(seconds, "total"),   number_of(seconds, "read"),   number_of(seconds, "size_field"),
                  number_of(seconds, "surface"), number_of(seconds, "volume"), number_of(seconds, "check"),
                  number_of(seconds, "write")};
  model.digest = text_of(report, "digest");
  if (model.tetloom.mesh) model.tetloom.mesh->edges_in_band = number_of(child_of(report, "quality"), "edges_in_band");
  for (const Json& warning : child_of(report, "warnings")) model.warnings.push_back(text_of(warning, "message"));
  const Json errors = child_of(report, "errors");
  if (!errors.empty()) model.tetloom.failure = text_of(errors[0], "code") + ": " + text_of(errors[0], "message");
  model.worst = worst_angle(report);
}

std::string verdict(const RealModel& model) {
  const std::string trouble = run_trouble(model.tetloom, model.facts);
  if (!trouble.empty()) return trouble;
  return model.tetloom.mesh->problem.empty() ? "valid" : "invalid";
}

bool is_valid(const RealModel& model) { return verdict(model) == "valid"; }

std::string gmsh_verdict(const RealModel& model) {
  if (!model.gmsh) return "-";
  const std::string trouble = run_trouble(*model.gmsh, model.facts);
  return trouble.empty() ? "valid" : trouble;
}

bool is_gmsh_valid(const RealModel& model) { return gmsh_verdict(model) == "valid"; }

bool can_compare(const RealModel& model) {
  return is_valid(model) && model.tetloom.mesh->tets > 0 && model.gmsh && model.gmsh->mesh &&
         model.gmsh->mesh->tets > 0 && model.gmsh->mesh->volume >= kComparableVolume * model.facts.volume();
}

Json to_json(const RealModel& model) {
  const StageTimes& s = model.stages;
  Json json = {{"model", model.name},
               {"verdict", verdict(model)},
               {"diagonal", model.facts.diagonal},
               {"volume", model.facts.volume()},
               {"regions", model.facts.volumes.size()},
               {"facets", model.facts.facets},
               {"closed_manifold", model.facts.closed_manifold},
               {"description_error", model.facts.error},
               {"tetloom", run_json(model.tetloom)},
               {"gmsh", nullptr},
               {"gmsh_verdict", gmsh_verdict(model)},
               {"digest", model.digest},
               {"warnings", model.warnings},
               {"worst_angle", nullptr},
               {"seconds",
                {{"total", s.total},
                 {"read", s.read},
                 {"size_field", s.size_field},
                 {"surface", s.surface},
                 {"volume", s.volume},
                 {"check", s.check},
                 {"write", s.write}}}};
  if (model.gmsh) json["gmsh"] = run_json(*model.gmsh);
  if (model.worst)
    json["worst_angle"] = {{"dihedral_deg", model.worst->dihedral_deg},
                           {"cause", model.worst->cause},
                           {"cause_deg", model.worst->cause_deg},
                           {"cause_length", model.worst->cause_length},
                           {"entities", model.worst->entities}};
  return json;
}

}  // namespace tetloom::bench
