#pragma once
// Sorting in parallel with an order that does not depend on the thread count.
#include <algorithm>
#include <memory>
#include <span>
#include <vector>

#include "tetloom/tasks.hpp"

namespace tetloom {

/// How many of the first `count` values of the merge of two sorted ranges come from `one`, the first where they tie.
template <class T>
std::size_t merge_share(std::span<const T> one, std::span<const T> other, std::size_t count) {
  std::size_t least = count > other.size() ? count - other.size() : 0, most = std::min(count, one.size());
  while (least < most) {
    const std::size_t middle = (least + most) / 2;
    if (other[count - middle - 1] < one[middle])
      most = middle;
    else
      least = middle + 1;
  }
  return least;
}

/// Merge sort of plain values; every merge is cut into blocks too. Afterwards equal values are neighbours; memory: one
/// copy.
template <class T>
void parallel_sort(std::vector<T>& values, const TaskRunner& runner) {
  constexpr std::size_t kBlock = std::size_t{1} << 14;
  const std::size_t count = values.size();
  runner.for_blocks(count, kBlock,
                    [&](std::size_t begin, std::size_t end) { std::sort(values.data() + begin, values.data() + end); });
  if (count <= kBlock) return;
  const std::unique_ptr<T[]> copy = std::make_unique_for_overwrite<T[]>(count);
  T *from = values.data(), *to = copy.get();
  for (std::size_t width = kBlock; width < count; width *= 2) {
    runner.for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
      const std::size_t first = begin / (2 * width) * (2 * width);
      const std::size_t middle = std::min(count, first + width), last = std::min(count, middle + width);
      const std::span<const T> one(from + first, middle - first), other(from + middle, last - middle);
      const std::size_t i = merge_share(one, other, begin - first), k = merge_share(one, other, end - first);
      std::merge(one.data() + i, one.data() + k, other.data() + (begin - first - i), other.data() + (end - first - k),
                 to + begin);
    });
    std::swap(from, to);
  }
  if (from == values.data()) return;
  runner.for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
    std::copy(from + begin, from + end, values.data() + begin);
  });
}

/// Sorts and drops what is there twice.
template <class T>
void parallel_sort_unique(std::vector<T>& values, const TaskRunner& runner) {
  constexpr std::size_t kBlock = std::size_t{1} << 14;
  parallel_sort(values, runner);
  const std::size_t count = values.size();
  const auto is_new = [&](std::size_t i) { return i == 0 || values[i - 1] < values[i]; };
  std::vector<std::size_t> firsts((count + kBlock - 1) / kBlock + 1, 0);
  runner.for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
    std::size_t& kept = firsts[begin / kBlock + 1];
    for (std::size_t i = begin; i < end; ++i) kept += is_new(i) ? 1 : 0;
  });
  for (std::size_t b = 1; b < firsts.size(); ++b) firsts[b] += firsts[b - 1];
  if (firsts.back() == count) return;
  std::vector<T> kept(firsts.back());
  runner.for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
    std::size_t next = firsts[begin / kBlock];
    for (std::size_t i = begin; i < end; ++i)
      if (is_new(i)) kept[next++] = values[i];
  });
  values = std::move(kept);
}

}  // namespace tetloom
