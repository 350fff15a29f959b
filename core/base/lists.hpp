#pragma once
// What is done to lists again and again.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tetloom {

/// Ascending, each value once.
template <class T>
void sort_unique(std::vector<T>& list) {
  std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// All lists, one after the other.
template <class T>
std::vector<T> joined(const std::vector<std::vector<T>>& lists) {
  std::size_t count = 0;
  for (const std::vector<T>& list : lists) count += list.size();
  std::vector<T> all;
  all.reserve(count);
  for (const std::vector<T>& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

/// The ends of an edge, the lower one first.
constexpr std::array<std::uint32_t, 2> ascending(std::uint32_t a, std::uint32_t b) {
  return {std::min(a, b), std::max(a, b)};
}

/// Whether a short list has an item.
constexpr bool has(const auto& list, std::uint32_t item) { return std::ranges::find(list, item) != std::end(list); }

}  // namespace tetloom
