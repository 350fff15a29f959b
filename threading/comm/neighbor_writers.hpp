#pragma once
// What a part tells all its neighbours in one step.
#include <algorithm>
#include <span>
#include <vector>

#include "tetloom/tasks.hpp"

namespace tetloom::detail {

/// One message per neighbour, written side by side.
class NeighborWriters {
 public:
  /// `neighbors` ascends and outlives the writers.
  explicit NeighborWriters(std::span<const PartId> neighbors) : neighbors_(neighbors), writers_(neighbors.size()) {}
  /// Pre: `part` is one of the neighbours.
  MessageWriter& to(PartId part) {
    const auto k = std::lower_bound(neighbors_.begin(), neighbors_.end(), part) - neighbors_.begin();
    return writers_[static_cast<std::size_t>(k)];
  }
  void send(PartTask& task) {
    for (std::size_t k = 0; k < neighbors_.size(); ++k) task.send(neighbors_[k], writers_[k].take());
  }

 private:
  std::span<const PartId> neighbors_;
  std::vector<MessageWriter> writers_;
};

}  // namespace tetloom::detail
