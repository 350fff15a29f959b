#pragma once
// Sorting in parallel with an order that does not depend on the thread count. Private to mesher/sizing.
#include <algorithm>
#include <vector>

#include "threading/task_runner.hpp"

namespace tetloom {

/// Merge sort of plain values. Afterwards equal values are neighbours; memory: one copy.
template <class T>
void parallel_sort(std::vector<T>& values, const TaskRunner& runner) {
  constexpr std::size_t kBlock = std::size_t{1} << 16;
  const auto at = [&](std::vector<T>& v, std::size_t i) {
    return v.begin() + static_cast<std::ptrdiff_t>(std::min(i, v.size()));
  };
  runner.for_blocks(values.size(), kBlock,
                    [&](std::size_t begin, std::size_t end) { std::sort(at(values, begin), at(values, end)); });
  std::vector<T> merged(values.size() > kBlock ? values.size() : 0);
  for (std::size_t width = kBlock; width < values.size(); width *= 2) {
    runner.for_each((values.size() + 2 * width - 1) / (2 * width), [&](std::size_t pair) {
      const std::size_t begin = 2 * width * pair, middle = begin + width, end = middle + width;
      std::merge(at(values, begin), at(values, middle), at(values, middle), at(values, end), at(merged, begin));
    });
    values.swap(merged);
  }
}

/// Sorts and drops what is there twice.
template <class T>
void parallel_sort_unique(std::vector<T>& values, const TaskRunner& runner) {
  parallel_sort(values, runner);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

}  // namespace tetloom
