// The claim: with 2 threads tetloom is faster than HXT from the STEP file to the file on disk and in its 3D stage
// alone, for the same size and for the same number of tets, in less memory per tet. Each mesher is a process of its own
// that reads the same model and writes the same format; they take turns. HXT makes about 1/2.3 of tetloom's tets of one
// size, so it is asked for a smaller one until the numbers agree.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/support/category_panel.hpp"
#include "bench/support/peer.hpp"
#include "bench/support/pipeline_run.hpp"
#include "bench/support/session.hpp"
#include "bench/support/volume_run.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kAgreement = 0.1;  // numbers of tets agree within this share

struct Options {
  std::vector<std::string> models = {"spline-block", "filleted-plate"};
  std::vector<double> tets = {5e6};
  int threads = 2;
  std::string format = "msh";
  SessionOptions session;
};

/// One mesher with one size on one model.
struct Contender {
  std::string name;
  PipelineTask task;
  PipelineSeries series;
};

struct PeerCase {
  std::string model_name;
  Contender tetloom{"tetloom", {}, {}}, same_size{"HXT, same size", {}, {}}, same_count{"HXT, same tets", {}, {}};

  std::array<const Contender*, 3> all() const { return {&tetloom, &same_size, &same_count}; }
};

double tets_of(const Contender& one) { return static_cast<double>(one.series.median().tets); }
double whole_speed(const Contender& one) { return tets_of(one) / one.series.median().seconds; }
double volume_speed(const Contender& one) { return tets_of(one) / one.series.volume_seconds(); }
double memory_per_tet(const Contender& one) { return one.series.median().bytes_per_tet(); }

double misfit(double count, double wanted) { return std::abs(count / wanted - 1); }

void print_table(std::span<const PeerCase> cases) {
  std::printf("  %-15s %9s %8s  %8s %8s %8s  %10s %10s  %6s %7s  %6s %6s\n", "mesher", "h", "M tets", "whole s", "3D s",
              "2D s", "k tets/s", "3D k tet/s", "B/tet", "file MB", "mean", "p1");
  for (const PeerCase& one : cases) {
    std::printf("%s, %d threads\n", one.model_name.c_str(), one.tetloom.task.threads);
    for (const Contender* contender : one.all()) {
      if (contender->series.empty()) {
        if (!contender->series.failure.empty())
          std::printf("  %-15s failed: %.90s\n", contender->name.c_str(), contender->series.failure.c_str());
        continue;
      }
      const PipelineSample& s = contender->series.median();
      std::printf("  %-15s %9.5g %8.3f  %8.2f %8.2f %8.2f  %10.0f %10.0f  %6.0f %7.0f  %6.4f %6.4f\n",
                  contender->name.c_str(), contender->task.size, 1e-6 * tets_of(*contender), s.seconds,
                  contender->series.volume_seconds(), s.surface, 1e-3 * whole_speed(*contender),
                  1e-3 * volume_speed(*contender), s.bytes_per_tet(), 1e-6 * static_cast<double>(s.file_bytes),
                  s.ratio_mean, s.ratio_p1);
    }
  }
}

void print_claims(std::span<const PeerCase> cases) {
  for (const PeerCase& one : cases)
    for (const Contender* peer : {&one.same_size, &one.same_count}) {
      if (peer->series.empty()) continue;
      std::printf(
          "%s, beside %s: %.2f x the tets/s from file to file, %.2f x in the 3D stage, %.2f x the bytes per tet",
          one.model_name.c_str(), peer->name.c_str(), whole_speed(one.tetloom) / whole_speed(*peer),
          volume_speed(one.tetloom) / volume_speed(*peer), memory_per_tet(one.tetloom) / memory_per_tet(*peer));
      const double apart = misfit(tets_of(*peer), tets_of(one.tetloom));
      const bool agrees = peer != &one.same_count || apart <= kAgreement;
      std::printf(agrees ? "\n" : "; but the numbers of tets differ by %.0f %%\n", 100 * apart);
    }
}

nlohmann::json to_json(const PeerCase& one) {
  nlohmann::json json = {{"model", one.model_name}, {"threads", one.tetloom.task.threads}};
  for (const Contender* contender : one.all()) {
    nlohmann::json& entry = json[contender->name];
    entry = {{"size", contender->task.size}, {"samples", contender->series.samples}};
    if (!contender->series.failure.empty()) entry["failure"] = contender->series.failure;
    if (contender->series.empty()) continue;
    entry["tets_per_second"] = whole_speed(*contender);
    entry["tets_per_second_3d"] = volume_speed(*contender);
    entry["bytes_per_tet"] = memory_per_tet(*contender);
  }
  return json;
}

/// One column per case, one marker per mesher.
Panel draw_panel(const char* title, const char* unit, std::span<const PeerCase> cases,
                 const std::function<double(const Contender&)>& value) {
  std::vector<CategoryValue> values;
  for (const PeerCase& one : cases)
    for (const Contender* contender : one.all())
      if (!contender->series.empty()) values.push_back({one.model_name, contender->name, value(*contender)});
  return draw_categories(title, "model", unit, values);
}

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), session_("volume_peers", options.session) {
    if (!options.session.no_peer) gmsh_ = gmsh_version();
  }

  void run() {
    session_.print_heading("beside gmsh/HXT " + (gmsh_.empty() ? "not run" : gmsh_));
    for (const std::string& model : options_.models)
      for (const double tets : options_.tets) prepare(session_.model_path(model), tets);
    const auto title = [](const PeerCase& one) { return one.model_name; };
    session_.take_turns(std::span(cases_), title, [&](PeerCase& one, int) { run_all(one); });
    print_table(cases_);
    std::printf("\n");
    print_claims(cases_);
    check_meshes();
    write_json();
    if (!options_.session.svg_path.empty()) draw();
  }

 private:
  PipelineTask task_of(const fs::path& model, double size) const {
    return {model, session_.folder() / ("mesh." + options_.format), size, options_.threads};
  }

  void prepare(const fs::path& model, double tets) {
    const double size = find_volume_size(session_.program(), {model}, tets);
    PeerCase& one = cases_.emplace_back();
    one.model_name = model.stem().string();
    one.tetloom.task = one.same_size.task = one.same_count.task = task_of(model, size);
    if (!gmsh_.empty()) find_same_count(one);
  }

  /// The size with which HXT makes as many tets as tetloom. What runs here warms the file cache and does not count.
  void find_same_count(PeerCase& one) {
    const double wanted = static_cast<double>(run_command(one.tetloom.task).tets);
    constexpr int kMostTries = 5;
    try {
      for (int i = 0; i < kMostTries; ++i) {
        std::fprintf(stderr, "%s: HXT with %.5g for %.0f tets\n", one.model_name.c_str(), one.same_count.task.size,
                     wanted);
        const auto count = static_cast<double>(run_hxt(one.same_count.task, session_.program()).tets);
        if (misfit(count, wanted) <= kAgreement / 2) return;
        one.same_count.task.size *= std::cbrt(count / wanted);
      }
    } catch (const std::exception& error) {
      one.same_count.series.failure = error.what();
    }
  }

  void run_all(PeerCase& one) {
    one.tetloom.series.samples.push_back(run_command(one.tetloom.task));
    if (gmsh_.empty()) return;
    for (Contender* peer : {&one.same_size, &one.same_count}) {
      try {
        peer->series.samples.push_back(run_hxt(peer->task, session_.program()));
      } catch (const std::exception& error) {
        peer->series.failure = error.what();
      }
    }
  }

  void check_meshes() const {
    for (const PeerCase& one : cases_)
      for (const PipelineSample& sample : one.tetloom.series.samples)
        if (sample.digest != one.tetloom.series.samples.front().digest)
          throw std::runtime_error(one.model_name + ": not the mesh that the first run gave");
  }

  void write_json() const {
    nlohmann::json cases = nlohmann::json::array();
    for (const PeerCase& one : cases_) cases.push_back(to_json(one));
    session_.write_json(cases, gmsh_);
  }

  void draw() const {
    const std::string peer = gmsh_.empty() ? "" : ", gmsh " + gmsh_ + " with HXT";
    Figure figure = session_.make_figure("tetloom beside HXT", std::to_string(options_.threads) + " threads" + peer);
    figure.panels = {draw_panel("From the STEP file to the mesh on disk", "million tets per second", cases_,
                                [](const Contender& one) { return 1e-6 * whole_speed(one); }),
                     draw_panel("3D stage", "million tets per second", cases_,
                                [](const Contender& one) { return 1e-6 * volume_speed(one); }),
                     draw_panel("Peak memory", "bytes per tet", cases_, memory_per_tet)};
    write_svg(figure, options_.session.svg_path);
  }

  Options options_;
  Session session_;
  std::string gmsh_;
  std::vector<PeerCase> cases_;
};

int run(int argc, char** argv) {
  Options options;
  CommandLine line("tetloom beside Gmsh with HXT: from the CAD file to the mesh on disk, and the 3D stage",
                   "volume_peers");
  line.add("--models", options.models, "demo models or CAD files");
  line.add("--tets", options.tets, "about how many tets of tetloom's").positive();
  line.add("--threads", options.threads, "of each mesher").positive();
  line.add("--format", options.format, "extension of the files that both write");
  add_session_options(line, options.session);
  add_plot_option(line, options.session);
  if (const auto status = line.parse(argc, argv)) return *status;
  if (!options.session.measure.empty()) {
    const nlohmann::json task = nlohmann::json::parse(options.session.measure);
    std::puts(judge_file(task.at("file").get<std::string>()).dump().c_str());
    return 0;
  }
  if (options.session.quick) {
    options.session.runs = 1;
    options.models = {"spline-block"};
    options.tets = {2e4};
  }
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) { return tetloom::bench::run_bench("volume_peers", tetloom::bench::run, argc, argv); }
