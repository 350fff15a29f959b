#pragma once
// Which of many items, alike for all ranks, this rank looks at.
#include <cstddef>

#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// Consecutive items.
struct ItemRange {
  std::size_t first = 0, last = 0;
  std::size_t size() const { return last - first; }
};

/// One of as many ranges of `count` items, of equal length, as there are ranks.
inline ItemRange own_share(std::size_t count, const SharedWork& work) {
  const auto rank = static_cast<std::size_t>(work.rank()), ranks = static_cast<std::size_t>(work.rank_count());
  return {count * rank / ranks, count * (rank + 1) / ranks};
}

}  // namespace tetloom
