#pragma once
// One measured adaptation, stage by stage, in a process of its own.
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tetloom::bench {

struct AdaptTask {
  std::string input;                 ///< a mesh file
  std::vector<std::string> metrics;  ///< as analytic_metric, one after the other
  int threads = 1;
  bool one_part = false;     ///< all in one part,
  double tets_per_part = 0;  ///< else in parts of so many tets; 0: as adapt_mesh sees fit
  std::string trace = {};    ///< not empty: the tasks go to this file
  std::string write = {};    ///< not empty: the last mesh goes to this file
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AdaptTask, input, metrics, threads, one_part, tets_per_part, trace, write)

/// How well a mesh fits a metric, by tetloom's own reckoning.
struct Fit {
  std::uint64_t tets = 0, edges = 0;
  double unit = 0, half_to_two = 0;  ///< shares of edges
  double shortest = 0, longest = 0, least_quality = 0, mean_quality = 0;
  double complexity = 0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Fit, tets, edges, unit, half_to_two, shortest, longest, least_quality, mean_quality,
                                   complexity)

/// The worst by each measure. Pre: not empty.
Fit worst_of(const std::vector<Fit>& fits);

struct AdaptSample {
  double set_up = 0, metric = 0, dealing = 0, parts = 0, result = 0;  ///< seconds, sums over the metrics
  double whole = 0;                                                   ///< of all calls of adapt_mesh
  double read = 0, write = 0;                                         ///< files, beside that
  std::vector<Fit> fits;                                              ///< one per metric
  std::uint64_t rounds = 0, most_parts = 0;
  std::uint64_t peak_bytes = 0;
  std::string digest;  ///< of the last mesh

  std::uint64_t tets_made() const;
  std::uint64_t most_tets() const;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AdaptSample, set_up, metric, dealing, parts, result, whole, read, write, fits,
                                   rounds, most_parts, peak_bytes, digest)

/// One column of tables and plots.
struct AdaptStage {
  const char* name;
  double AdaptSample::*seconds;
};
inline constexpr AdaptStage kAdaptStages[] = {{"set up", &AdaptSample::set_up},   {"metric", &AdaptSample::metric},
                                              {"dealing", &AdaptSample::dealing}, {"parts", &AdaptSample::parts},
                                              {"result", &AdaptSample::result},   {"whole", &AdaptSample::whole}};

/// In this very process; for a process started for nothing else. Throws Error, std::invalid_argument.
AdaptSample measure_adapt_here(const AdaptTask& task);

/// In a process of its own, in memory that was touched right before: `program --measure`. Throws std::runtime_error
/// with what it said when it fails.
AdaptSample measure_adapt_apart(const std::string& program, const AdaptTask& task);

/// The median of each stage, which may be of different runs; what is no time is the first sample's. Pre: not empty.
AdaptSample median_adapt(const std::vector<AdaptSample>& samples);

/// What another program is to be given, or what it made.
struct FitTask {
  std::string mesh, metric;
  std::string solution = {};  ///< not empty: the metric at the points of the mesh goes to this file
  bool sizes = false;         ///< there, iso:H as sizes
  std::string copy = {};      ///< not empty: the mesh goes to this file without its edges
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FitTask, mesh, metric, solution, sizes, copy)

/// How well the mesh fits. Throws Error.
Fit judge_fit_here(const FitTask& task);
/// In a process of its own: `program --measure`. Throws std::runtime_error.
Fit judge_fit_apart(const std::string& program, const FitTask& task);

}  // namespace tetloom::bench
