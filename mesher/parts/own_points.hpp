#pragma once
// The points of a part's shell that are its own, to answer other parts from.
#include <cstddef>
#include <span>
#include <vector>

#include "core/spatial/bvh.hpp"
#include "mesher/parts/shell_steps.hpp"

namespace tetloom::parts {

/// Made in n log n. Searches may come from any number of threads.
class OwnPoints {
 public:
  explicit OwnPoints(std::vector<ShellPoint> points);

  /// The points that are not outside of a doubt's ball: all of those on its sphere, and of those inside of it the
  /// `most_per_doubt` nearest to the tet, where one would do to say that it is none. Each once, ascending by key.
  std::vector<ShellPoint> find_in(std::span<const Doubt> doubts, std::size_t most_per_doubt) const;

 private:
  void mark_in(const Doubt& doubt, std::size_t most, std::vector<char>& is_in) const;

  std::vector<ShellPoint> points_;  ///< by key
  Bvh bvh_;
};

OwnPoints find_own_points(const SharedInput& input, const PartState& state, PartId part);

}  // namespace tetloom::parts
