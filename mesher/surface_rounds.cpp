#include "mesher/surface_rounds.hpp"

#include "mesher/intersection/self_intersection.hpp"

namespace tetloom {
namespace {

constexpr int kMostRounds = 6;         // behind the first
constexpr int kMostFittingRounds = 3;  // in which narrow places count
// By then sizes are a sixteenth, and what triangles sag by a 256th.
constexpr int kEnoughForCrossings = 4;
// Where there are hardly more triangles than before, another round costs little.
constexpr double kHardlyMore = 1.1;

}  // namespace

bool SurfaceRounds::seeks_misfits() const { return refines_ && count_ < kMostFittingRounds; }

// Where there were more crossings than are told, they may still become fewer.
bool SurfaceRounds::cross_in_model(const SurfaceRound& now) const {
  return count_ >= kEnoughForCrossings && last_.crossings > 0 && last_.crossings < IntersectionSearch{}.most &&
         now.crossings >= last_.crossings &&
         static_cast<double>(now.triangles) > kHardlyMore * static_cast<double>(last_.triangles);
}

NextStep SurfaceRounds::decide(const SurfaceRound& now) {
  const bool crosses = now.crossings > 0, is_last = count_ >= kMostRounds || cross_in_model(now);
  // Narrow places that were refined until triangles crossed, as those where faces touch.
  const bool is_worse = was_free_ && crosses && count_ >= kMostFittingRounds;
  was_free_ |= !crosses;
  last_ = now;
  ++count_;
  if (is_worse) return NextStep::AcceptBefore;
  if (now.fits()) return now.sheet_crossings == 0 ? NextStep::Accept : NextStep::Judge;
  if (crosses && is_last) return NextStep::KeepFacets;
  return refines_ && !is_last ? NextStep::Refine : NextStep::Judge;
}

}  // namespace tetloom
