#pragma once
// From the CAD file to the mesh on disk, by the command and by a peer: whole processes, measured from outside.
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace tetloom::bench {

struct PipelineTask {
  std::filesystem::path model, output;
  double size = 0;  ///< target edge length
  int threads = 1;
  std::string max_memory = {};  ///< the command's option; empty: its default
};

struct PipelineSample {
  double seconds = 0;                                                   ///< wall time of the whole process
  double read = 0, size_field = 0, surface = 0, volume = 0, write = 0;  ///< its stages; 0 where it does not say
  std::uint64_t tets = 0;
  double ratio_mean = 0, ratio_p1 = 0;
  std::uint64_t peak_bytes = 0, swap_bytes = 0;
  std::uint64_t file_bytes = 0;  ///< of the output
  std::string digest;            ///< equal digests: equal meshes; empty for peers

  double bytes_per_tet() const { return static_cast<double>(peak_bytes) / static_cast<double>(tets); }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PipelineSample, seconds, read, size_field, surface, volume, write, tets, ratio_mean,
                                   ratio_p1, peak_bytes, swap_bytes, file_bytes, digest)

/// `tetloom mesh MODEL -o OUTPUT --size H --threads T`, with a report; its stages are those of the report, and its
/// seconds count reading, checking and everything else. The output, with the folder of its pieces, is removed.
/// Throws std::runtime_error with what it said when it fails.
PipelineSample run_command(const PipelineTask& task);

/// Whether the command writes files of this extension.
bool command_writes(const std::string& extension);

/// `gmsh MODEL -3 -algo hxt -nt T -bin -clmin H -clmax H -o OUTPUT`, likewise. `program` is this bench: it judges what
/// was written, in a process of its own (see judge_file).
PipelineSample run_hxt(const PipelineTask& task, const std::string& program);

/// What a process of run_hxt prints: {"tets", "ratio_mean", "ratio_p1"} of a mesh file.
nlohmann::json judge_file(const std::filesystem::path& path);

/// The samples of one mesher on one task, in the order in which they ran.
class PipelineSeries {
 public:
  std::vector<PipelineSample> samples = {};
  std::string failure = {};  ///< of the last run, when it failed

  bool empty() const { return samples.empty(); }
  /// Of median `seconds`. Pre: not empty.
  const PipelineSample& median() const;
  /// The median seconds of the 3D stage, which may be those of another run. Pre: not empty.
  double volume_seconds() const;
};

}  // namespace tetloom::bench
