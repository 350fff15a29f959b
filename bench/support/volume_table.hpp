#pragma once
// All samples of one model, size and number of threads, and how they are shown.
#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/support/volume_run.hpp"

namespace tetloom::bench {

/// The runs of one mesher on one task, in the order in which they ran; none where it does not run.
struct VolumeSeries {
  std::string mesher;
  std::vector<VolumeSample> samples;
  std::string failure;  ///< of the last run, when it failed

  bool empty() const { return samples.empty(); }
  /// The sample of median time. Pre: not empty.
  const VolumeSample& median() const;
  double tets_per_second() const;
};

struct VolumeCase {
  std::string model_name;
  VolumeTask task;
  VolumeSeries tetloom{"tetloom", {}, {}}, hxt{"hxt", {}, {}}, tetgen{"tetgen", {}, {}}, netgen{"netgen", {}, {}};

  std::array<const VolumeSeries*, 4> all() const { return {&tetloom, &hxt, &tetgen, &netgen}; }
  /// "sphere, h 1.2, gradient 0.05"
  std::string title() const;
};

/// Shapes and sizes, one line per mesher and case.
void print_quality(std::span<const VolumeCase> cases);
/// Seconds, tets per second and memory, likewise.
void print_speed(std::span<const VolumeCase> cases);
/// Where tetloom's seconds went, and what the recovery had to do, one line per case.
void print_stages(std::span<const VolumeCase> cases);
/// What is asked of tetloom, and where it is not reached: one line each.
void print_misses(std::span<const VolumeCase> cases);

nlohmann::json to_json(const VolumeCase& volume_case);

}  // namespace tetloom::bench
