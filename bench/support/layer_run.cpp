#include "bench/support/layer_run.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "bench/support/child_process.hpp"
#include "bench/support/peer.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Words = std::vector<std::string>;

constexpr double kJudgingSeconds = 900;
constexpr double kGrowth = 1.2, kBox = 3;
constexpr int kEdgesPerTurn = 24;  // or round faces lose more volume than a verdict allows

Json read_json(const fs::path& path) {
  std::ifstream file(path);
  Json json = Json::parse(file, nullptr, false);
  return json.is_discarded() ? Json::object() : json;
}

Words command_of(const LayerTask& task, double edge, const fs::path& mesh) {
  return {TETLOOM_COMMAND,
          "mesh",
          task.model,
          "-o",
          mesh,
          "--size",
          exact_text(edge),
          "--curvature",
          std::to_string(kEdgesPerTurn),
          "--threads",
          std::to_string(task.threads),
          "--quiet"};
}

Words command_of(const LayerTask& task, const fs::path& mesh, const fs::path& report) {
  const double edge = edge_of(task.model, task.relative_size);
  const double mean = task.mean_edge > 0 ? task.mean_edge : edge;
  Words words = command_of(task, edge, mesh);
  const auto add = [&](std::initializer_list<std::string> more) { words.insert(words.end(), more); };
  add({"--report", report});
  if (task.outside) add({"--far-field", exact_text(kBox)});
  if (task.with_layers)
    add({"--layers", "*", "--first-height", exact_text(task.setting.first_height * mean), "--growth",
         exact_text(kGrowth), "--layer-count", std::to_string(task.setting.count)});
  return words;
}

void take_report(const Json& report, LayerRun& run) {
  run.digest = report.value("digest", Json()).is_string() ? report["digest"].get<std::string>() : "";
  run.layers = report.value("layers", Json::object());
  if (run.layers.contains("cells"))
    for (const auto& [kind, count] : run.layers["cells"].items()) run.layer_cells += count.get<std::uint64_t>();
  run.layer_seconds = run.figure("seconds");
  const Json errors = report.value("errors", Json::array());
  if (errors.empty()) return;
  run.failure = errors[0].value("message", "");
  run.is_located = !errors[0].value("entities", Json::array()).empty() && errors[0].value("point", Json()).is_array();
}

void judge_apart(const std::string& judge, const fs::path& mesh, const Json& report, LayerRun& run) {
  const ChildResult child = run_child({judge, "--measure", mesh}, {kJudgingSeconds});
  const Json figures = Json::parse(child.output, nullptr, false);
  if (child.exit_status != 0 || !figures.is_object()) {
    run.verdict.problem = "the mesh cannot be judged";
    return;
  }
  run.verdict.problem = figures["problem"];
  run.verdict.inverted = figures["inverted"];
  run.cells = figures["cells"];
  const double wanted = report.value("volume", Json::object()).value("model", 0.0);
  run.verdict.volume_error = wanted > 0 ? std::abs(figures["volume"].get<double>() / wanted - 1) : 1;
}

// Debian's OpenFOAM wants to be told where it is.
FoamCheck judge_by_check_mesh(const fs::path& foam) {
  const std::string script =
      "export WM_PROJECT_DIR=${WM_PROJECT_DIR:-/usr/share/openfoam}; exec checkMesh -case '" + foam.string() + "'";
  const ChildResult child = run_child({"sh", "-c", script}, {kJudgingSeconds});
  if (child.exit_status == 0) return read_check_mesh(child.output);
  return {false, "checkMesh fails", 0, 0};
}

}  // namespace

const std::vector<LayerSetting>& layer_settings() {
  static const std::vector<LayerSetting> settings{{"A", 0.05, 8}, {"B", 0.02, 20}, {"C", 1e-4, 42}};
  return settings;
}

double edge_of(const fs::path& model, double relative_size) {
  const ChildResult info = run_child({TETLOOM_COMMAND, "info", model, "--quiet", "--report", "/dev/stdout"}, {300});
  const Json report = Json::parse(info.output, nullptr, false);
  if (!report.is_object() || !report.contains("model"))
    throw std::runtime_error("'" + model.string() + "' is no model: " + info.output);
  const Json box = report["model"].at("bounding_box");
  double squares = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double side = box[1][axis].get<double>() - box[0][axis].get<double>();
    squares += side * side;
  }
  return relative_size * std::sqrt(squares);
}

double mean_edge_of(const LayerTask& task, const fs::path& folder) {
  fs::create_directories(folder);
  const double edge = edge_of(task.model, task.relative_size);
  const fs::path path = folder / "surface.vtu";
  Words words = command_of(task, edge, path);
  words.emplace_back("--surface-only");
  if (run_child(words, {task.timeout}).exit_status != 0) return edge;
  const Mesh mesh = read_mesh(path);
  fs::remove(path);
  double sum = 0;
  for (const auto& [a, b, c] : mesh.tri_to_vert)
    sum += distance(mesh.points[a], mesh.points[b]) + distance(mesh.points[b], mesh.points[c]) +
           distance(mesh.points[c], mesh.points[a]);
  return mesh.tri_to_vert.empty() ? edge : sum / static_cast<double>(3 * mesh.tri_to_vert.size());
}

LayerRun run_layers(const LayerTask& task, const std::string& judge, const fs::path& folder) {
  fs::create_directories(folder);
  const fs::path mesh = folder / "mesh.vtu", report = folder / "report.json", foam = folder / "mesh.foam";
  LayerRun run;
  try {
    const ChildResult child = run_child(command_of(task, mesh, report), {task.timeout});
    run.exit_status = child.exit_status;
    run.timed_out = child.timed_out;
    run.seconds = child.seconds, run.cpu_seconds = child.cpu_seconds;
    run.peak_bytes = child.peak_bytes;
    if (child.exit_status != 0) run.failure = child.output.substr(0, 300);
  } catch (const std::runtime_error& error) {
    run.failure = error.what();
    return run;
  }
  const Json said = read_json(report);
  take_report(said, run);
  if (!run.made_mesh()) return run;
  judge_apart(judge, mesh, said, run);
  if (task.by_check_mesh && is_installed("checkMesh")) run.verdict.by_check_mesh = judge_by_check_mesh(foam);
  fs::remove_all(foam);
  fs::remove(mesh);
  return run;
}

Json judge_layers(const fs::path& path) {
  const Mesh mesh = read_mesh(path);
  const ValidationReport report = validate_mesh(mesh);
  const CellQuality cells = compute_quality(mesh).cells;
  write_mesh(mesh, fs::path(path).replace_extension(".foam"));
  return {{"problem", report.valid() ? "" : report.problems.front().message},
          {"inverted", cells.inverted},
          {"cells", cells.count},
          {"volume", cells.volume}};
}

Json to_json(const LayerRun& run) {
  const LayerVerdict& verdict = run.verdict;
  Json json = {
      {"exit_status", run.exit_status},     {"timed_out", run.timed_out},   {"failure", run.failure},
      {"is_located", run.is_located},       {"seconds", run.seconds},       {"cpu_seconds", run.cpu_seconds},
      {"layer_seconds", run.layer_seconds}, {"peak_bytes", run.peak_bytes}, {"cells", run.cells},
      {"layer_cells", run.layer_cells},     {"layers", run.layers},         {"digest", run.digest},
      {"problem", verdict.problem},         {"inverted", verdict.inverted}, {"volume_error", verdict.volume_error}};
  if (verdict.by_check_mesh)
    json["check_mesh"] = {{"is_fine", verdict.by_check_mesh->is_fine},
                          {"complaint", verdict.by_check_mesh->complaint},
                          {"non_orthogonal", verdict.by_check_mesh->non_orthogonal},
                          {"skewness", verdict.by_check_mesh->skewness}};
  return json;
}

}  // namespace tetloom::bench
