#pragma once
// What a run of the command came to, for --report and for the summary.
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/tetloom/exit_status.hpp"
#include "mesher/tets/optimizer.hpp"
#include "tetloom/check.hpp"
#include "tetloom/error.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::app {

/// Three numbers, or null.
nlohmann::ordered_json point_json(const std::optional<Vec3>& point);

/// Numbers of what the mesh has.
struct RunCounts {
  std::uint64_t points = 0, triangles = 0, tets = 0, regions = 0;
};

/// Wall time of the stages.
struct RunSeconds {
  double read = 0, size_field = 0, surface = 0, layers = 0, volume = 0, second_order = 0, check = 0, write = 0;
};

/// Everything that a run found out until it ended, however it ended. Lengths in model units.
struct RunReport {
  std::string input;
  ExitStatus status = ExitStatus::Done;
  int threads = 1;
  int parts = 1;
  RunCounts counts;
  RunSeconds seconds;
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  std::optional<QualityReport> quality;
  std::optional<double> model_volume;
  QualityGoals goals;              ///< of the tets, where a volume was filled
  tets::OptimizeReport optimizer;  ///< how far they were reached
  std::string digest;              ///< empty while there is no mesh
  std::vector<Diagnostic> errors, warnings;
  /// What a command adds of its own; its members stand beside the others.
  nlohmann::ordered_json extra = nlohmann::ordered_json::object();
  EntityTable entities;  ///< for names of faces

  double total_seconds() const;
};

/// Adds `error` and takes the exit status from it, unless there is one already.
void add_failure(RunReport& report, const Diagnostic& error);

/// The largest memory that this process has used, plus the largest that one of its workers has.
std::uint64_t peak_bytes();

/// The report as JSON, schema 1:
/// {"schema", "status", "input", "threads", "parts", "counts": {…}, "seconds": {…}, "peak_bytes", "quality": {…},
/// "volume": {…}, "digest", "errors": […], "warnings": […]}. Numbers that the run did not get to are null. Entities are
/// shown by their tags. Names that are not UTF-8 have their invalid bytes replaced.
std::string to_json(const RunReport& report);

/// Writes it, completely or not at all. Throws Error(OutputFailed).
void write_report(const RunReport& report, const std::filesystem::path& path);

/// One diagnostic as in "errors".
nlohmann::ordered_json to_json(const Diagnostic& diagnostic);

/// {"count", "forced_by_angles", "forced_by_triangles", "forced_by_points", "not_forced", "worst": [{"dihedral_deg",
/// "point", "cause", "cause_deg", "cause_length", "entities"}, …]}: the tets with a smaller dihedral angle than asked
/// for; "cause" is "surface_angle", "surface_triangle", "surface_points", "narrow_region" or null, and "cause_length"
/// how far apart the points are, or the sides of the region. Both are in "forced_by_points".
nlohmann::ordered_json acute_tets_json(const tets::OptimizeReport& optimizer);

}  // namespace tetloom::app
