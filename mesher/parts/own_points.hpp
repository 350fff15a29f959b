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

  /// The points that are not outside of an open ball: all of those on its sphere, and of those inside of it the
  /// `most_per_ball` nearest to the tet, where one would do to say that it is none. Each once, ascending by key.
  std::vector<ShellPoint> find_in(std::span<const OpenBall> open_balls, std::size_t most_per_ball) const;

 private:
  void mark_in(const OpenBall& ball, std::size_t most, std::vector<char>& is_in) const;

  std::vector<ShellPoint> points_;  ///< by key
  Bvh bvh_;
};

OwnPoints find_own_points(const SharedInput& input, const PartShell& shell, PartId part);

}  // namespace tetloom::parts
