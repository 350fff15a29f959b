#include "bench/support/adapt_peers.hpp"

#include <algorithm>
#include <stdexcept>

#include "bench/support/child_process.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kMostPasses = 10;
constexpr double kWorthAPass = 0.005;  // of the share of unit edges

std::string first_installed(const std::vector<std::string>& programs) {
  const auto found = std::find_if(programs.begin(), programs.end(), is_installed);
  return found == programs.end() ? "" : *found;
}

/// On a machine of 2 cores (AMD EPYC, Debian 12) with other load, from this cube of 10 thousand tets. MMG is 5.8.
constexpr KnownFigure kKnown[] = {
    {"iso", "MMG", 19.2, 51.7e3, 0.964, 0.858, 500},
    {"iso", "PUMI MeshAdapt", 20.8, 43.0e3, 0.899, 0.813, 320},
    {"iso", "ParMmg, 2 ranks", 22.1, 44.3e3, 0.966, 0.860, 790},
    {"iso", "Omega_h, 2 threads", 37.1, 28.5e3, 0.936, 0.788, 930},
    {"iso", "refine, h = 0.05", 26.6, 3.2e3, 0.996, 0.907, 320},
    {"cube-linear", "refine", 26, 0, 0.994, 0.895, 0},
    {"cube-linear", "MMG", 8, 0, 0.944, 0.843, 0},
    {"cube-linear", "Omega_h", 5, 0, 0.926, 0.780, 0},
    {"cube-linear", "feflo.a (published)", 0, 0, 0.983, 0.851, 0},
    {"polar-2", "refine", 66, 0, 0.970, 0.847, 0},
    {"polar-2", "MMG", 15, 0, 0.934, 0.816, 0},
    {"shock", "MMG", 32.6, 24e3, 0.961, 0.850, 0},
    {"moving-shock", "MMG", 56.5, 17e3, 0, 0, 0},
    {"moving-shock", "Omega_h", 82, 0, 0, 0, 0},
};

void run_pass(const AdaptPeer& peer, const std::vector<std::string>& command, const fs::path& output,
              AdaptPeerSample& sample) {
  fs::remove(output);
  const ChildResult child = run_child(command);
  const std::size_t tail = child.output.size() > 1000 ? child.output.size() - 1000 : 0;
  if (child.exit_status != 0 || !fs::exists(output))
    throw std::runtime_error(peer.name + " failed: ..." + child.output.substr(tail));
  sample.seconds += child.seconds;
  sample.peak_bytes = std::max(sample.peak_bytes, child.peak_bytes);
  ++sample.passes;
}

}  // namespace

std::vector<std::string> AdaptPeer::command(const std::string& input, const std::string& solution,
                                            const std::string& output) const {
  if (name == "refine") return {program, "adapt", input, "-m", solution, "-x", output};
  return {program, "-v", "1", "-in", input, "-sol", solution, "-out", output};
}

std::vector<AdaptPeer> find_adapt_peers() {
  // Without a CAD model refine stops at corners that edges of the file meet in; it takes tensors alone.
  return {{"MMG", first_installed({"mmg3d_O3", "mmg3d"})}, {"refine", first_installed({"ref"}), false, false}};
}

double AdaptPeerSample::tets_made() const {
  double sum = 0;
  for (const Fit& fit : fits) sum += static_cast<double>(fit.tets);
  return sum;
}

double AdaptPeerSample::most_tets() const {
  double most = 0;
  for (const Fit& fit : fits) most = std::max(most, static_cast<double>(fit.tets));
  return most;
}

AdaptPeerSample measure_adapt_peer(const AdaptPeer& peer, const AdaptCase& what, const std::string& input,
                                   const std::string& program, const fs::path& folder) {
  const std::string solution = folder / (peer.name + ".solb"), output = folder / (peer.name + ".out.meshb");
  const std::string next = folder / (peer.name + ".in.meshb");
  fs::copy_file(input, next, fs::copy_options::overwrite_existing);
  AdaptPeerSample sample;
  for (const std::string& metric : what.metrics) {
    const FitTask task{next, metric, solution, peer.takes_sizes, peer.takes_edges ? "" : next};
    Fit fit;
    judge_fit_apart(program, task);
    for (int pass = 0; pass < kMostPasses; ++pass) {
      run_pass(peer, peer.command(next, solution, output), output, sample);
      fs::rename(output, next);
      const double before = fit.unit;
      fit = judge_fit_apart(program, task);
      if (metric.starts_with("iso:") || fit.unit < before + kWorthAPass) break;
    }
    sample.fits.push_back(fit);
  }
  return sample;
}

std::vector<KnownFigure> known_figures(const std::string& case_name) {
  std::vector<KnownFigure> figures;
  for (const KnownFigure& figure : kKnown)
    if (figure.case_name == case_name) figures.push_back(figure);
  return figures;
}

}  // namespace tetloom::bench
