#include "bench/support/real_run.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "bench/support/child_process.hpp"
#include "bench/support/facet_file.hpp"
#include "bench/support/peer.hpp"
#include "bench/support/surface_distance.hpp"
#include "bench/support/temporary_folder.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"
#include "tetloom/model.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

constexpr double kJudgingSeconds = 600;  // that a judge may take, beyond what any mesh needs

/// The last lines of a program's output, on one line.
std::string end_of(const std::string& output) {
  constexpr std::size_t kLength = 300;
  std::string text = output.substr(output.size() > kLength ? output.size() - kLength : 0);
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// Empty where there is none, or none that can be read.
Json read_json(const fs::path& path) {
  std::ifstream file(path);
  Json json = Json::parse(file, nullptr, false);
  return json.is_discarded() ? Json::object() : json;
}

/// Runs a mesher and fills in what can be seen from outside.
ChildResult run_mesher(const Words& command, const RealRunOptions& options, MesherRun& run) {
  const ChildResult child = run_child(command, {options.timeout});
  run.exit_status = child.exit_status;
  run.timed_out = child.timed_out;
  run.seconds = child.seconds, run.cpu_seconds = child.cpu_seconds;
  run.peak_bytes = child.peak_bytes;
  return child;
}

/// Asks a process of the bench itself, which may fail without harm, what a mesh is worth.
void judge_apart(const JudgeTask& task, const RealRunOptions& options, MesherRun& run) {
  if (!fs::exists(task.mesh)) return;
  const ChildResult judge = run_child({options.judge, "--measure", Json(task).dump()}, {kJudgingSeconds});
  const Json figures = Json::parse(judge.output, nullptr, false);
  if (judge.exit_status == 0 && figures.is_object())
    run.mesh = figures.get<MeshFigures>();
  else
    run.failure = "the mesh cannot be judged: " + end_of(judge.output);
}

/// Of closed facets. Where these pass through themselves, the exact sum counts some space twice.
double volume_within(const Mesh& facets) {
  constexpr double kSame = 0.005;
  const double sum = std::abs(enclosed_volume(facets)), wound = wound_volume(facets);
  return std::abs(wound - sum) > kSame * sum ? wound : sum;
}

/// Of a file that the command may not be able to read.
void describe_facets(const fs::path& path, ModelFacts& facts) {
  facts.facets = is_facet_file(path);
  if (!facts.facets) return;
  const Mesh facets = read_facet_file(path);
  facts.closed_manifold = is_closed_manifold(facets);
  const Box3 box = box_of(facets.points);
  facts.diagonal = box.diagonal();
  if (facts.closed_manifold) facts.volumes = {volume_within(facets)};
}

ModelFacts describe(const fs::path& path, const fs::path& folder, const RealRunOptions& options) {
  ModelFacts facts;
  try {
    describe_facets(path, facts);
  } catch (const std::exception& error) {
    facts.error = error.what();
  }
  const std::vector<double> within = facts.volumes;  // as the file has it, apart from the command
  const fs::path report = folder / "info.json";
  const ChildResult info = run_child({options.command, "info", path, "--quiet", "--report", report}, {options.timeout});
  if (info.exit_status != 0)
    facts.error = end_of(info.output);
  else
    take_description(read_json(report), facts);
  if (!within.empty() && facts.volumes.size() == 1) facts.volumes = within;
  return facts;
}

void run_tetloom(const fs::path& folder, const RealRunOptions& options, RealModel& model) {
  const fs::path mesh = folder / "tetloom.msh", report = folder / "report.json";
  Words command{options.command,
                "mesh",
                model.path,
                "-o",
                mesh,
                "--relative-size",
                exact_text(options.relative_size),
                "--curvature",
                exact_text(options.curvature),
                "--threads",
                std::to_string(options.threads),
                "--report",
                report,
                "--quiet"};
  std::istringstream more(options.options);
  for (std::string word; more >> word;) command.push_back(word);
  const ChildResult child = run_mesher(command, options, model.tetloom);
  const Json said = read_json(report);
  judge_apart({mesh, false, options.distance ? model.path : fs::path(), said}, options, model.tetloom);
  if (child.exit_status != 0) model.tetloom.failure = end_of(child.output);
  take_report(said, model);
  fs::remove(mesh);
}

/// What Gmsh is given: the CAD file itself, or a script that fills the facets as they are.
fs::path peer_input(const fs::path& path, const fs::path& folder) {
  if (!is_facet_file(path)) return path;
  fs::path facets = fs::absolute(path);
  if (path.extension() != ".stl") {
    facets = folder / "facets.stl";
    write_mesh(read_facet_file(path), facets);
  }
  const fs::path script = folder / "facets.geo";
  std::ofstream(script) << "Merge \"" << facets.string() << "\";\nSurface Loop(1) = {1};\nVolume(1) = {1};\n";
  return script;
}

MesherRun run_gmsh(const fs::path& path, double diagonal, const fs::path& folder, const RealRunOptions& options) {
  const fs::path mesh = folder / "gmsh.msh";
  const double size = diagonal * options.relative_size;
  MesherRun run;
  const ChildResult child = run_mesher(
      {"gmsh", peer_input(path, folder), "-3", "-algo", "hxt", "-nt", std::to_string(options.threads), "-clcurv",
       exact_text(options.curvature), "-clmax", exact_text(size), "-clmin", exact_text(size / 10), "-bin", "-o", mesh},
      options, run);
  if (child.exit_status != 0) run.failure = end_of(child.output);
  judge_apart({mesh, true}, options, run);
  fs::remove(mesh);
  return run;
}

/// Turns the tets of regions whose volumes sum up to less than nothing.
void turn_regions(Mesh& mesh) {
  const auto region_of = [&](std::size_t tet) {
    return mesh.tet_to_entity.empty() ? std::uint32_t{ModelRegionId::kNone} : mesh.tet_to_entity[tet];
  };
  std::map<std::uint32_t, double> volumes;
  for (std::size_t t = 0; t < mesh.tet_to_vert.size(); ++t) {
    const auto& [a, b, c, d] = mesh.tet_to_vert[t];
    const Vec3& o = mesh.points[a];
    volumes[region_of(t)] += dot(cross(mesh.points[b] - o, mesh.points[c] - o), mesh.points[d] - o);
  }
  for (std::size_t t = 0; t < mesh.tet_to_vert.size(); ++t)
    if (volumes[region_of(t)] < 0) std::swap(mesh.tet_to_vert[t][2], mesh.tet_to_vert[t][3]);
}

/// The model that a mesh is classified on.
ModelDocument model_as_meshed(const JudgeTask& task) {
  ModelDocument document = read_model(task.model);
  for (const std::vector<ModelRegionId>& solids : rebuilt_solids(task.report))
    if (std::optional<ModelDocument> rebuilt = rebuild_solids(document, solids)) document = std::move(*rebuilt);
  return document;
}

}  // namespace

RealModel run_real_model(const fs::path& path, const RealRunOptions& options) {
  const TemporaryFolder folder;
  RealModel model;
  model.name = path.filename().string(), model.path = path;
  model.facts = describe(path, folder.path(), options);
  run_tetloom(folder.path(), options, model);
  if (options.no_peer || model.facts.diagonal <= 0) return model;
  try {
    model.gmsh = run_gmsh(path, model.facts.diagonal, folder.path(), options);
  } catch (const std::exception& error) {
    model.gmsh = MesherRun{.failure = error.what(), .mesh = {}};
  }
  return model;
}

void to_json(Json& json, const JudgeTask& task) {
  json = {{"mesh", task.mesh.string()},
          {"lenient", task.lenient},
          {"model", task.model.string()},
          {"report", {{"rebuilt", nullptr}}}};
  if (task.report.contains("rebuilt")) json["report"]["rebuilt"] = task.report.at("rebuilt");
}

void from_json(const Json& json, JudgeTask& task) {
  task.mesh = json.at("mesh").get<std::string>(), task.model = json.at("model").get<std::string>();
  json.at("lenient").get_to(task.lenient);
  task.report = json.at("report");
}

MeshFigures judge_mesh_file(const JudgeTask& task) {
  Mesh mesh = read_mesh(task.mesh);
  if (task.lenient) turn_regions(mesh);
  const ValidationReport validation = validate_mesh(mesh);
  const QualityReport quality = compute_quality(mesh);
  MeshFigures figures;
  figures.tets = quality.tets.count, figures.triangles = quality.triangles.count;
  figures.inverted = quality.cells.inverted, figures.regions = quality.cells.regions.size();
  figures.volume = quality.cells.volume;
  figures.min_dihedral_deg = quality.tets.min_dihedral_deg;
  figures.ratio_mean = quality.tets.mean_ratio_mean, figures.ratio_p1 = quality.tets.mean_ratio_p1;
  figures.ratio_min = quality.tets.mean_ratio_min;
  if (!task.model.empty()) figures.surface_distance = surface_distance(mesh, *model_as_meshed(task).model);
  if (!validation.valid()) figures.problem = validation.problems.front().message;
  return figures;
}

}  // namespace tetloom::bench
