#include "apps/tetloom/parts_whole.hpp"

namespace tetloom::app {

void note_summary(const PartsSummary& summary, const PartsFigures& figures, RunReport& report) {
  report.counts.points = static_cast<std::uint64_t>(figures.vertices);
  report.counts.triangles = summary.triangles, report.counts.tets = summary.tets;
  report.counts.regions = summary.quality.cells.regions.size();
  report.quality = summary.quality;
  report.digest = summary.digest;
}

}  // namespace tetloom::app
