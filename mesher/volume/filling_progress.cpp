#include "mesher/volume/filling_progress.hpp"

#include <algorithm>

#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

namespace {

std::uint64_t estimated_tets(const VolumeInput& input, const Complex& complex) {
  const VolumeInput part{complex.points, complex.tri_to_vert, complex.tri_to_sides, {}, nullptr, input.sizes};
  return static_cast<std::uint64_t>(std::clamp(estimate_filling(part).tets, 1.0, 1e15));
}

}  // namespace

FillingProgress::FillingProgress(const VolumeInput& input, const Complex& complex)
    : whole_(estimated_tets(input, complex)), region_(3, complex.regions.front()) {}

void FillingProgress::reach(FillingStep step, const TaskRunner& runner) {
  runner.check_cancelled();
  const std::uint64_t share = static_cast<std::uint64_t>(step), now = whole_ / 100 * share + whole_ % 100 * share / 100;
  if (now <= reached_) return;
  runner.advance(now - reached_, step == FillingStep::Done ? region_ : ModelEntity{});
  reached_ = now;
}

}  // namespace tetloom::volume
