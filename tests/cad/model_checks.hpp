#pragma once
// Checks that any geometric model must pass, for tests.
#include <filesystem>
#include <string>

#include "tetloom/model.hpp"

namespace tetloom::test {

struct TimedDocument {
  ModelDocument document;
  double seconds = 0;
};

TimedDocument read_timed(const std::filesystem::path& path, const ReadOptions& options = {});

/// How well the boundaries of faces hold together.
struct LoopReport {
  std::size_t uses = 0;
  std::size_t disconnected = 0;  ///< uses whose end is not the start of the next, in space or in (u,v)
  std::size_t off_curve = 0;     ///< uses whose parameter curve leaves the edge by more than the tolerances
  double worst_uv_gap = 0;       ///< as the distance in space that the gap in (u,v) spans
  double worst_point_gap = 0;
  double worst_curve_gap = 0;
};

LoopReport check_loops(const GeometricModel& model);

std::string describe(const Diagnostic& diagnostic);

}  // namespace tetloom::test
