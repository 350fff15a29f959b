#pragma once
// Whether the surface is made once more with smaller sizes, and what else may come after a round of it.
#include <cstddef>

namespace tetloom {

/// What one round of the surface came to.
struct SurfaceRound {
  std::size_t triangles = 0;
  std::size_t crossings = 0;        ///< of triangles that bound solids; no more than IntersectionSearch::most
  std::size_t sheet_crossings = 0;  ///< of others, which may cross
  std::size_t misfits = 0;          ///< narrow places that are worth smaller sizes
  bool takes_back = false;          ///< where walls touch, sizes become larger again

  bool fits() const { return crossings == 0 && misfits == 0 && !takes_back; }
};

/// What follows a round of surface meshing.
enum class NextStep {
  Accept,        ///< the surface is as wished
  AcceptBefore,  ///< this one crosses itself; the last one that did not is better
  KeepFacets,    ///< it crosses, and sizes do not help: facets may, as they are
  Judge,         ///< it is the last; whether it may be used depends on where it crosses
  Refine,        ///< smaller sizes, and another round
};

/// Counts the rounds of one surface and decides after each. Crossings that do not become fewer while sizes are halved
/// are the model's own: a line along which faces cross meets twice as many triangles each time.
class SurfaceRounds {
 public:
  /// Unless `refines`, there is one round.
  explicit SurfaceRounds(bool refines) : refines_(refines) {}

  /// Those that have been decided on.
  int count() const { return count_; }
  /// Whether narrow places count in the round to come: in the first few.
  bool seeks_misfits() const;
  /// What the last round came to; of nothing before the first.
  const SurfaceRound& last() const { return last_; }

  /// What to do after a round.
  NextStep decide(const SurfaceRound& now);

 private:
  bool cross_in_model(const SurfaceRound& now) const;

  bool refines_;
  int count_ = 0;
  SurfaceRound last_;
  bool was_free_ = false;  // a round before did not cross
};

}  // namespace tetloom
