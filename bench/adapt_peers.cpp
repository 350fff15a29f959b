// The claim: with 2 threads tetloom leads a mesh to a metric faster than MMG and refine do, to edges and tets that fit
// it no worse, from file to file. Each is a process of its own; they take turns. Where a peer is not installed, known
// figures stand in its place, which were not measured here and say so.
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/support/adapt_cases.hpp"
#include "bench/support/adapt_peers.hpp"
#include "bench/support/adapt_run.hpp"
#include "bench/support/category_panel.hpp"
#include "bench/support/cube.hpp"
#include "bench/support/session.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostOfFailure = 300;

struct Options {
  std::vector<std::string> cases = adapt_case_names();
  std::string input;
  int threads = 2;
  SessionOptions session;
};

/// One program on one case.
struct Contender {
  std::string name;
  std::vector<AdaptPeerSample> samples = {};
  std::vector<std::string> digests = {};  ///< tetloom's
  std::string failure = {};               ///< of the last run, when it failed

  const AdaptPeerSample& median() const {
    std::vector<const AdaptPeerSample*> order;
    for (const AdaptPeerSample& sample : samples) order.push_back(&sample);
    std::sort(order.begin(), order.end(),
              [](const AdaptPeerSample* a, const AdaptPeerSample* b) { return a->seconds < b->seconds; });
    return *order[(order.size() - 1) / 2];
  }
  double speed() const { return median().tets_made() / median().seconds; }
  double bytes_per_tet() const { return static_cast<double>(median().peak_bytes) / median().most_tets(); }
};

/// `all`: tetloom first.
struct PeerCase {
  AdaptCase what;
  std::vector<Contender> all = {};
};

void print_contender(const Contender& one) {
  if (one.samples.empty()) {
    // What went wrong stands at the end of what a program says.
    const std::size_t begin = one.failure.size() > kMostOfFailure ? one.failure.size() - kMostOfFailure : 0;
    std::printf("  %-20s failed: ...%s\n", one.name.c_str(), one.failure.substr(begin).c_str());
    return;
  }
  const AdaptPeerSample& sample = one.median();
  const Fit fit = worst_of(sample.fits);
  std::printf("  %-20s %8.3f %8.2f %6d %10.1f  %6.2f %6.3f %6.3f  %6.4f %6.4f %7.0f\n", one.name.c_str(),
              1e-6 * static_cast<double>(sample.fits.back().tets), sample.seconds, sample.passes, 1e-3 * one.speed(),
              100 * fit.unit, fit.shortest, fit.longest, fit.mean_quality, fit.least_quality, one.bytes_per_tet());
}

/// "-" for 0, which stands for what is not known.
std::string known_text(double value, int digits) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.*f", digits, value);
  return value > 0 ? text : "-";
}

/// What is known of peers that did not run.
void print_known(const PeerCase& one) {
  for (const KnownFigure& known : known_figures(one.what.name)) {
    const auto has_run = [&](const Contender& other) { return other.name == known.who && !other.samples.empty(); };
    if (std::any_of(one.all.begin(), one.all.end(), has_run)) continue;
    std::printf("  %-20s %8s %8s %6s %10s  %6s %13s  %6s %6s %7s  known, not measured here\n", known.who, "",
                known_text(known.seconds, 1).c_str(), "", known_text(1e-3 * known.tets_per_second, 1).c_str(),
                known_text(100 * known.unit, 1).c_str(), "", known_text(known.mean_quality, 3).c_str(), "",
                known_text(known.bytes_per_tet, 0).c_str());
  }
}

void print_table(std::span<const PeerCase> cases) {
  std::printf("  %-20s %8s %8s %6s %10s  %6s %6s %6s  %6s %6s %7s\n", "program", "M tets", "s", "passes", "k tets/s",
              "% unit", "short", "long", "mean", "least", "B/tet");
  for (const PeerCase& one : cases) {
    std::printf("%s\n", one.what.name.c_str());
    for (const Contender& contender : one.all) print_contender(contender);
    print_known(one);
  }
  std::printf("\n");
}

void print_claims(std::span<const PeerCase> cases) {
  for (const PeerCase& one : cases)
    for (const Contender& peer : one.all)
      if (&peer != &one.all.front() && !peer.samples.empty())
        std::printf("%s, beside %s: %.2f x the tets/s, %.3f of its seconds, %.2f x the bytes per tet\n",
                    one.what.name.c_str(), peer.name.c_str(), one.all.front().speed() / peer.speed(),
                    one.all.front().median().seconds / peer.median().seconds,
                    one.all.front().bytes_per_tet() / peer.bytes_per_tet());
}

nlohmann::json to_json(const PeerCase& one) {
  nlohmann::json json = {{"case", one.what.name}, {"metrics", one.what.metrics}};
  for (const Contender& contender : one.all) {
    nlohmann::json& entry = json["programs"][contender.name];
    entry = {{"samples", contender.samples}};
    if (!contender.failure.empty()) entry["failure"] = contender.failure;
    if (contender.samples.empty()) continue;
    entry["tets_per_second"] = contender.speed();
    entry["bytes_per_tet"] = contender.bytes_per_tet();
  }
  for (const KnownFigure& known : known_figures(one.what.name))
    json["known_not_measured_here"].push_back({{"program", known.who},
                                               {"seconds", known.seconds},
                                               {"tets_per_second", known.tets_per_second},
                                               {"unit", known.unit},
                                               {"mean_quality", known.mean_quality},
                                               {"bytes_per_tet", known.bytes_per_tet}});
  return json;
}

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), session_("adapt_peers", options.session) {
    if (options.session.no_peer) return;
    for (const AdaptPeer& peer : find_adapt_peers()) {
      if (!peer.program.empty())
        peers_.push_back(peer);
      else
        missing_ += (missing_.empty() ? "" : ", ") + peer.name;
    }
  }

  void run() {
    std::string peers;
    for (const AdaptPeer& peer : peers_) peers += (peers.empty() ? "beside " : ", ") + peer.name;
    if (!missing_.empty()) peers += (peers.empty() ? "" : "; ") + ("not in PATH and not run: " + missing_);
    session_.print_heading(peers.empty() ? "no peer" : peers);
    input_ = options_.input.empty() ? make_cube(session_).string() : options_.input;
    for (const std::string& name : options_.cases) {
      PeerCase& one = cases_.emplace_back(PeerCase{find_adapt_case(name)});
      one.all.push_back({"tetloom"});
      for (const AdaptPeer& peer : peers_) one.all.push_back({peer.name});
    }
    const auto title = [](const PeerCase& one) { return one.what.name; };
    session_.take_turns(std::span(cases_), title, [&](PeerCase& one, int) { run_all(one); });
    print_table(cases_);
    print_claims(cases_);
    write_json();
    if (!options_.session.svg_path.empty()) draw();
  }

 private:
  void run_all(PeerCase& one) {
    run_tetloom(one);
    for (std::size_t i = 0; i < peers_.size(); ++i) {
      Contender& peer = one.all[i + 1];
      try {
        peer.samples.push_back(measure_adapt_peer(peers_[i], one.what, input_, session_.program(), session_.folder()));
      } catch (const std::exception& error) {
        peer.failure = error.what();
      }
    }
  }

  void run_tetloom(PeerCase& one) {
    const fs::path output = session_.folder() / "tetloom.meshb";
    const AdaptSample sample = measure_adapt_apart(
        session_.program(), {input_, one.what.metrics, options_.threads, false, 0, "", output.string()});
    fs::remove(output);
    Contender& self = one.all.front();
    self.samples.push_back({sample.read + sample.whole + sample.write, sample.peak_bytes,
                            static_cast<int>(one.what.metrics.size()), sample.fits});
    self.digests.push_back(sample.digest);
    if (sample.digest != self.digests.front())
      throw std::runtime_error(one.what.name + ": not the mesh that the first run gave");
  }

  void write_json() const {
    nlohmann::json cases = nlohmann::json::array();
    for (const PeerCase& one : cases_) cases.push_back(to_json(one));
    session_.write_json(cases, "");
  }

  Panel panel(const char* title, const char* unit, const std::function<double(const Contender&)>& value) const {
    std::vector<CategoryValue> values;
    for (const PeerCase& one : cases_)
      for (const Contender& contender : one.all)
        if (!contender.samples.empty()) values.push_back({one.what.name, contender.name, value(contender)});
    return draw_categories(title, "metric", unit, values);
  }

  void draw() const {
    Figure figure = session_.make_figure("Adaptation beside others",
                                         "tetloom with " + std::to_string(options_.threads) + " threads" +
                                             (missing_.empty() ? "" : "; not installed: " + missing_));
    figure.panels = {
        panel("From file to file", "thousand tets per second", [](const Contender& c) { return 1e-3 * c.speed(); }),
        panel("Unit edges", "%", [](const Contender& c) { return 100 * worst_of(c.median().fits).unit; }),
        panel("Mean ratio, on average", "in the metric",
              [](const Contender& c) { return worst_of(c.median().fits).mean_quality; }),
        panel("Peak memory", "bytes per tet", [](const Contender& c) { return c.bytes_per_tet(); })};
    figure.columns = 2;
    write_svg(figure, options_.session.svg_path);
  }

  Options options_;
  Session session_;
  std::string input_, missing_;
  std::vector<AdaptPeer> peers_;
  std::vector<PeerCase> cases_;
};

void print_measured(const nlohmann::json& task) {
  const nlohmann::json json = task.contains("input") ? nlohmann::json(measure_adapt_here(task.get<AdaptTask>()))
                                                     : nlohmann::json(judge_fit_here(task.get<FitTask>()));
  std::puts(json.dump().c_str());
}

int run(int argc, char** argv) {
  Options options;
  CommandLine line("tetloom beside MMG and refine: from a mesh and a metric to another mesh", "adapt_peers");
  line.add("--cases", options.cases, "iso, cube-linear, polar-2, shock, moving-shock, or metrics such as iso:0.05")
      .separated_by(';');
  line.add("--input", options.input, "a mesh of tets to begin with; default: the unit cube in 10 thousand tets")
      .existing_file();
  line.add("--threads", options.threads, "of tetloom").positive();
  add_session_options(line, options.session);
  add_plot_option(line, options.session);
  if (const auto status = line.parse(argc, argv)) return *status;
  if (!options.session.measure.empty()) {
    print_measured(nlohmann::json::parse(options.session.measure));
    return 0;
  }
  if (options.session.quick) {
    options.session.runs = 1;
    options.cases = quick_adapt_case_names();
  }
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) { return tetloom::bench::run_bench("adapt_peers", tetloom::bench::run, argc, argv); }
