// The claim: walls of real models are covered by valid boundary layers, inside and outside, of the heights asked for.
// `tetloom mesh --layers` runs as a user would run it on all model files of the folders given, with three settings;
// meshes are judged by tetloom's own check and by OpenFOAM's checkMesh where it is installed.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/support/child_process.hpp"
#include "bench/support/layer_run.hpp"
#include "bench/support/model_files.hpp"
#include "bench/support/session.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<std::string> folders;
  std::string only, settings = "ABC";
  bool inside_only = false;
  LayerTask task;
  SessionOptions session;
};

struct Case {
  LayerTask task;
  LayerRun run;

  std::string name() const {
    return task.model.stem().string() + (task.outside ? " out " : " in ") + task.setting.name;
  }
};

// Valid, or refused with faces and a point.
bool is_good(const LayerRun& run) {
  if (!run.made_mesh()) return run.is_located;
  return run.verdict.is_valid() && (!run.verdict.by_check_mesh || run.verdict.by_check_mesh->is_fine);
}

std::string verdict_of(const LayerRun& run) {
  if (run.timed_out) return "too slow";
  if (!run.made_mesh()) return run.is_located ? "refused" : "FAILED";
  if (!run.verdict.is_valid()) return "INVALID";
  if (!run.verdict.by_check_mesh) return "valid";
  return run.verdict.by_check_mesh->is_fine ? "valid, OK" : "valid, COMPLAINS";
}

// Of the walls, without a layer for another reason than a gap.
double uncovered_share(const LayerRun& run) {
  double area = 0;
  for (const auto& place : run.layers.value("limited", nlohmann::json::array()))
    if (place["reason"] != "gap") area += place["uncovered"].get<double>();
  return area / run.figure("wall_area");
}

void print_line(const Case& one) {
  const LayerRun& run = one.run;
  const FoamCheck foam = run.verdict.by_check_mesh.value_or(FoamCheck{});
  const auto percent = [&](const char* name) { return 100 * run.figure(name); };
  std::printf("%-34.34s %9llu %6.1f %6.1f %6.1f %6.1f %7.3f %6.2f %8.4f %6.2f %7.1f %6.1f  %s\n", one.name().c_str(),
              static_cast<unsigned long long>(run.layer_cells), percent("full_count"), percent("at_least_one"),
              percent("thickness"), percent("first_height_within_10pct"), run.figure("min_scaled_jacobian"),
              run.figure("scaled_jacobian_p1"), 100 * foam.non_orthogonal, foam.skewness, run.seconds,
              run.layer_seconds, verdict_of(run).c_str());
  std::fflush(stdout);
}

// A measure over all meshes: how many of them reach what is asked for.
void print_row(const char* measure, const std::vector<Case>& cases, bool (*counts)(const LayerRun&),
               bool (*reaches)(const LayerRun&)) {
  std::size_t all = 0, good = 0;
  for (const Case& one : cases) {
    if (!counts(one.run)) continue;
    ++all;
    good += reaches(one.run);
  }
  if (all == 0) return std::printf("  %-64s -\n", measure), void();
  std::printf("  %-64s %zu of %zu%s\n", measure, good, all, good < all ? "  MISSED" : "");
}

void print_summary(const std::vector<Case>& cases) {
  const auto any = [](const LayerRun&) { return true; };
  const auto meshes = [](const LayerRun& run) { return run.made_mesh(); };
  const auto judged = [](const LayerRun& run) { return run.verdict.by_check_mesh.has_value(); };
  std::printf("\n");
  print_row("valid, or refused with faces and a point", cases, any, is_good);
  print_row("valid by tetloom's check", cases, meshes, [](const LayerRun& run) { return run.verdict.is_valid(); });
  print_row("checkMesh complains of aspect ratios at most", cases, judged,
            [](const LayerRun& run) { return run.verdict.by_check_mesh->is_fine; });
  print_row("faces above 70 degrees: at most .02 %", cases, judged,
            [](const LayerRun& run) { return run.verdict.by_check_mesh->non_orthogonal <= 2e-4; });
  print_row("largest skewness below 4", cases, judged,
            [](const LayerRun& run) { return run.verdict.by_check_mesh->skewness < 4; });
  print_row("least scaled Jacobian of layer cells: .02", cases, meshes,
            [](const LayerRun& run) { return run.figure("min_scaled_jacobian") >= 0.02; });
  print_row("first percentile of it: .4", cases, meshes,
            [](const LayerRun& run) { return run.figure("scaled_jacobian_p1") >= 0.4; });
  print_row("first height within 10 % on 95 % of the covered area", cases, meshes,
            [](const LayerRun& run) { return run.figure("first_height_within_10pct") >= 0.95; });
  print_row("at least one layer on 99.5 % of the walls", cases, meshes,
            [](const LayerRun& run) { return run.figure("at_least_one") >= 0.995; });
  print_row("the same where no wall is too near on the other side", cases, meshes,
            [](const LayerRun& run) { return uncovered_share(run) <= 0.005; });
  print_row("first cells within 15 degrees of the normal, 99th percentile", cases, meshes,
            [](const LayerRun& run) { return run.figure("first_angle_p99_deg") <= 15; });
  print_row("growth of straight stacks to 1e-6", cases, meshes,
            [](const LayerRun& run) { return run.figure("growth_error") <= 1e-6; });
  print_row("layers take at most 30 % of the run", cases, meshes,
            [](const LayerRun& run) { return run.layer_seconds <= 0.3 * run.seconds; });
  for (const LayerSetting& setting : layer_settings()) {
    double thickness = 0, area = 0;
    for (const Case& one : cases) {
      if (one.task.setting.name != setting.name || !one.run.made_mesh()) continue;
      area += 1;
      thickness += one.run.figure("thickness");
    }
    if (area > 0)
      std::printf("  %-64s %.1f %%\n", ("mean share of the thickness reached, " + setting.name).c_str(),
                  100 * thickness / area);
  }
  for (const Case& one : cases) {
    const LayerVerdict& verdict = one.run.verdict;
    const std::string complaint = verdict.by_check_mesh ? verdict.by_check_mesh->complaint : "";
    const std::string said = one.run.made_mesh() ? verdict.problem + complaint : one.run.failure;
    if (!said.empty()) std::printf("  %s: %.200s\n", one.name().c_str(), said.c_str());
  }
}

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), session_("layers_coverage", options.session) {}

  void run() {
    const std::vector<fs::path> models =
        options_.session.quick ? quick_models() : find_models(options_.folders, options_.only);
    if (models.empty()) throw std::runtime_error("no model files");
    const bool judges = options_.task.by_check_mesh && is_installed("checkMesh");
    session_.print_heading(judges ? "judged by OpenFOAM's checkMesh as well" : "without OpenFOAM's checkMesh");
    std::printf("%-34s %9s %6s %6s %6s %6s %7s %6s %8s %6s %7s %6s  %s\n", "model, side, setting", "cells", "full%",
                "any%", "thick%", "first%", "min SJ", "p1 SJ", ">70deg%", "skew", "s", "layers", "verdict");
    for (const fs::path& model : models) run_model(model);
    print_summary(cases_);
    if (options_.session.quick) check_quick();
  }

 private:
  void run_model(const fs::path& model) {
    LayerTask task = options_.task;
    task.model = model;
    task.mean_edge = mean_edge_of(task, session_.folder() / "run");
    for (const bool outside : {false, true})
      for (const LayerSetting& setting : layer_settings()) {
        if (options_.settings.find(setting.name) == std::string::npos || (outside && options_.inside_only)) continue;
        Case one{task, {}};
        one.task.setting = setting, one.task.outside = outside;
        one.run = run_layers(one.task, session_.program(), session_.folder() / "run");
        print_line(one);
        cases_.push_back(std::move(one));
        write_json();
      }
  }

  void write_json() const {
    nlohmann::json cases = nlohmann::json::array();
    for (const Case& one : cases_) {
      cases.push_back(to_json(one.run));
      cases.back()["model"] = one.task.model.filename();
      cases.back()["outside"] = one.task.outside;
      cases.back()["setting"] = one.task.setting.name;
    }
    session_.write_json(cases, "");
  }

  std::vector<fs::path> quick_models() const { return {session_.model_path("machined-part")}; }

  void check_quick() const {
    for (const Case& one : cases_)
      if (!one.run.made_mesh() || !one.run.verdict.is_valid() || one.run.figure("at_least_one") < 0.5)
        throw std::runtime_error(one.name() + " is not as it must be: " + verdict_of(one.run) + " " + one.run.failure);
  }

  Options options_;
  Session session_;
  std::vector<Case> cases_;
};

int run(int argc, char** argv) {
  Options options;
  options.session.runs = 1;
  CommandLine line("Boundary layers on real models: validity, coverage, shape", "layers_coverage");
  line.add("FOLDERS", options.folders, "folders with models, or model files");
  line.add("--only", options.only, "only models whose names match this regular expression, in any case");
  line.add("--settings", options.settings, "of A, B and C");
  line.add_flag("--inside", options.inside_only, "leave the space around the models out");
  line.add("--relative-size", options.task.relative_size, "target edge, as a share of the model's diagonal").positive();
  line.add("--threads", options.task.threads).positive();
  line.add("--timeout", options.task.timeout, "seconds of a run");
  add_session_options(line, options.session);
  if (const auto status = line.parse(argc, argv)) return *status;
  if (!options.session.measure.empty()) {
    std::puts(judge_layers(options.session.measure).dump().c_str());
    return 0;
  }
  options.task.by_check_mesh = !options.session.no_peer;
  if (options.session.quick) options.task.relative_size = 0.06, options.settings = "A";
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) {
  return tetloom::bench::run_bench("layers_coverage", tetloom::bench::run, argc, argv);
}
