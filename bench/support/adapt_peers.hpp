#pragma once
// Other programs that lead meshes to metrics, where they are in PATH, and figures of such where they are not.
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/support/adapt_cases.hpp"
#include "bench/support/adapt_run.hpp"

namespace tetloom::bench {

/// A program that reads a mesh and a metric at its points and writes another mesh.
struct AdaptPeer {
  std::string name;     ///< "MMG", "refine"
  std::string program;  ///< empty where none is in PATH
  bool takes_edges = true;
  bool takes_sizes = true;  ///< numbers in place of tensors

  std::vector<std::string> command(const std::string& input, const std::string& solution,
                                   const std::string& output) const;
};

/// MMG (`mmg3d_O3` or `mmg3d`) and NASA's refine (`ref`).
std::vector<AdaptPeer> find_adapt_peers();

/// From file to file, by whoever.
struct AdaptPeerSample {
  double seconds = 0;  ///< of all passes over all metrics
  std::uint64_t peak_bytes = 0;
  int passes = 0;
  std::vector<Fit> fits;  ///< one per metric

  double tets_made() const;
  double most_tets() const;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(AdaptPeerSample, seconds, peak_bytes, passes, fits)

/// Runs `peer` on every metric of the case. A metric known at points alone is known too roughly on a coarse mesh, so
/// it is evaluated anew on what comes out, and the peer runs again until the share of unit edges grows by less than
/// half a percent; passes and their times add up, evaluating and judging do not count. `program` is this bench, which
/// does these in processes of their own. Files go to `folder`. Throws std::runtime_error with the end of what the peer
/// said when it fails.
AdaptPeerSample measure_adapt_peer(const AdaptPeer& peer, const AdaptCase& what, const std::string& input,
                                   const std::string& program, const std::filesystem::path& folder);

/// What was measured or published elsewhere, on other machines; 0 where unknown.
struct KnownFigure {
  const char* case_name;
  const char* who;
  double seconds = 0, tets_per_second = 0;
  double unit = 0, mean_quality = 0;  ///< share of edges; mean ratio
  double bytes_per_tet = 0;
};
std::vector<KnownFigure> known_figures(const std::string& case_name);

}  // namespace tetloom::bench
