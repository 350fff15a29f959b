#pragma once
// One measured run from the CAD file to the mesh on disk, stage by stage, in a process of its own.
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tetloom::bench {

struct StageTask {
  std::string model, output;
  double size = 0;  ///< target edge length
  int threads = 1;
  bool one_part = false;     ///< the volume in one part,
  double tets_per_part = 0;  ///< else in parts of so many tets; 0: as the mesher sees fit
  std::string trace = {};    ///< not empty: the tasks of the volume go to this file
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StageTask, model, output, size, threads, one_part, tets_per_part, trace)

struct StageSample {
  double read = 0, size_field = 0, surface = 0, volume = 0, write = 0;
  double whole = 0;  ///< all of these and what lies between them, without the start of the process
  std::uint64_t tets = 0, peak_bytes = 0;
  std::string digest;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StageSample, read, size_field, surface, volume, write, whole, tets, peak_bytes,
                                   digest)

/// One column of tables and plots.
struct StageKind {
  const char* name;
  double StageSample::*seconds;
};
inline constexpr StageKind kStages[] = {{"size field", &StageSample::size_field},
                                        {"surface", &StageSample::surface},
                                        {"volume", &StageSample::volume},
                                        {"write", &StageSample::write},
                                        {"whole", &StageSample::whole}};

/// In this very process; for a process started for nothing else. Throws Error.
StageSample measure_stages_here(const StageTask& task);

/// In a process of its own: `program --measure`. Throws std::runtime_error with what it said when it fails.
StageSample measure_stages_apart(const std::string& program, const StageTask& task);

/// The median of each stage, which may be of different runs; what is no time is the first sample's. Pre: not empty.
StageSample median_stages(const std::vector<StageSample>& samples);
/// The same with the least of each stage.
StageSample best_stages(const std::vector<StageSample>& samples);

}  // namespace tetloom::bench
