#pragma once
// How far the filling of one complex is, told to the host.
#include <cstdint>

#include "mesher/volume/complex.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

/// What is done, in this order. The values are how much of the time that takes, in percent, on large meshes of one
/// size.
enum class FillingStep : std::uint8_t {
  Points = 24,
  Core = 29,
  Delaunay = 52,
  Recovery = 58,
  Join = 66,
  Optimized = 95,
  Improved = 97,
  Done = 100
};

/// Counts in tets, as they are estimated: the whole depends on the input alone. One task at a time may use it.
class FillingProgress {
 public:
  FillingProgress(const VolumeInput& input, const Complex& complex);

  std::uint64_t whole() const { return whole_; }

  /// Advances the stage up to the end of `step`; what was reached before, by another way of filling, stays. Errors:
  /// Cancelled.
  void reach(FillingStep step, const TaskRunner& runner);

  /// So much of the whole a task of several may advance by, where it does `share` of what takes so many percent.
  std::uint64_t part_of_whole(int percent, double share) const {
    return static_cast<std::uint64_t>(static_cast<double>(whole_) * percent / 100 * share);
  }
  /// What tasks have advanced by on their own.
  void note(std::uint64_t advanced) { reached_ += advanced; }

 private:
  std::uint64_t whole_, reached_ = 0;
  ModelEntity region_;
};

}  // namespace tetloom::volume
