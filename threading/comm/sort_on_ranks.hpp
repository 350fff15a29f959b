#pragma once
// Sorting what ranks have together, by samples (Frazer & McKellar 1970).
#include <algorithm>
#include <span>
#include <vector>

#include "threading/comm/shared_work.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom {

/// The values of all ranks in order, cut into consecutive pieces of about equal length: those of rank 0 come first.
/// Returns this rank's piece. Pre: no two values are equal, so that the order does not depend on who had them. All
/// ranks call it, in `together`. O(n log n / ranks), and each rank sends what it had once.
template <class T>
std::vector<T> sort_on_ranks(std::vector<T> own, const SharedWork& work) {
  constexpr std::size_t kSamples = 64;  // of a rank; pieces differ by some percent
  const auto ranks = static_cast<std::size_t>(work.rank_count());
  if (ranks == 1) {
    parallel_sort(own, work.runner());
    return own;
  }
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
    parallel_sort(own, work.runner());
    // Every sample stands for as many values as any other one.
    const std::size_t step = std::max<std::size_t>(1, own.size() / kSamples);
    std::vector<T> samples;
    for (std::size_t i = step / 2; i < own.size(); i += step) samples.push_back(own[i]);
    writer.put(static_cast<std::uint64_t>(step));
    writer.put_array<T>(samples);
  });
  struct Sample {
    T value;
    std::uint64_t count;
  };
  std::vector<T> bounds;  // below the first of them: the first rank
  std::vector<T> piece;
  const std::vector<Bytes> sent = work.exchange([&](std::span<MessageWriter> to) {
    std::vector<Sample> samples;
    std::uint64_t all = 0, before = 0;
    for (const Bytes& bytes : given) {
      MessageReader reader(bytes);
      const auto count = reader.get<std::uint64_t>();
      for (const T& value : reader.get_view<T>()) samples.push_back({value, count}), all += count;
    }
    std::ranges::sort(samples, [](const Sample& a, const Sample& b) { return a.value < b.value; });
    for (const Sample& sample : samples) {
      before += sample.count;
      if (bounds.size() + 1 < ranks && before * ranks >= all * (bounds.size() + 1)) bounds.push_back(sample.value);
    }
    auto begin = own.cbegin();
    for (std::size_t rank = 0; rank < ranks; ++rank) {
      const auto end = rank < bounds.size() ? std::lower_bound(begin, own.cend(), bounds[rank]) : own.cend();
      to[rank].put_array<T>({begin, end});
      begin = end;
      if (rank >= bounds.size()) break;
    }
    for (std::size_t rank = bounds.size() + 1; rank < ranks; ++rank) to[rank].put_array<T>({});
  });
  work.each([&] {
    own = {};
    piece = joined_lists<T>(sent);
    parallel_sort(piece, work.runner());
  });
  return piece;
}

}  // namespace tetloom
