#pragma once
// Metrics of a mesh of which this rank has its own tets and those around them.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "core/base/exact_sum.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {

/// Which of the tets at hand are this rank's own, and how all ranks add up; by itself: all of them, and one rank.
struct OwnTets {
  std::size_t begin = 0, end = SIZE_MAX;
  std::function<void(ExactSum&)> sum;              ///< over all ranks, in place; empty: of one rank
  std::function<void(std::span<double>)> largest;  ///< the same of maxima

  std::size_t first() const { return begin; }
  std::size_t count_of(std::size_t tets) const { return std::min(end, tets) - begin; }
  void add_up(ExactSum& value) const {
    if (sum) sum(value);
  }
  double largest_of(double value) const {
    if (largest) largest(std::span(&value, 1));
    return value;
  }
};

/// As in metric.hpp, of all ranks together; the same on all of them, bit by bit, as of one that has it all. Collective
/// calls. `mesh`: all tets at the vertices of own tets, ascending in the whole mesh.
double complexity(const MetricField& metric, const TetView& mesh, const OwnTets& own, const BlockLoop& loop);
/// The metric of vertices that no own tet has is of no use afterwards.
TurningResult limit_turning(MetricField& metric, const TetView& mesh, const OwnTets& own, const BlockLoop& loop);

}  // namespace tetloom::adapt
