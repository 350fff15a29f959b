#include "threading/parts/number_ids.hpp"

#include <algorithm>

#include "core/base/lists.hpp"

namespace tetloom {

std::vector<std::uint64_t> number_ids(std::span<const std::uint64_t> ids, std::size_t& count, const SharedWork& work) {
  const auto ranks = static_cast<std::size_t>(work.rank_count()), rank = static_cast<std::size_t>(work.rank());
  std::uint64_t highest = 0;
  for (const Bytes& bytes :
       work.all_gather([&](MessageWriter& writer) { writer.put(ids.empty() ? std::uint64_t{0} : ids.back()); }))
    highest = std::max(highest, MessageReader(bytes).get<std::uint64_t>());
  const std::uint64_t width = highest / ranks + 1;
  const std::vector<Bytes> asked = work.exchange([&](std::span<MessageWriter> to) {
    for (std::size_t r = 0; r < ranks; ++r) {
      const auto begin = std::ranges::lower_bound(ids, r * width), end = std::ranges::lower_bound(ids, (r + 1) * width);
      to[r].put_array(std::span<const std::uint64_t>(begin, end));
    }
  });
  std::vector<std::uint64_t> at_home;
  for (const Bytes& bytes : asked) {
    const auto list = MessageReader(bytes).get_view<std::uint64_t>();
    at_home.insert(at_home.end(), list.begin(), list.end());
  }
  sort_unique(at_home);
  std::size_t first = 0, sum = 0, r = 0;
  for (const Bytes& bytes :
       work.all_gather([&](MessageWriter& writer) { writer.put(std::uint64_t{at_home.size()}); })) {
    if (r++ == rank) first = sum;
    sum += MessageReader(bytes).get<std::uint64_t>();
  }
  count = sum;
  const std::vector<Bytes> told = work.exchange([&](std::span<MessageWriter> to) {
    for (std::size_t i = 0; i < ranks; ++i) {
      const auto list = MessageReader(asked[i]).get_view<std::uint64_t>();
      to[i].put_each(list, [&](std::uint64_t id) {
        return first + static_cast<std::uint64_t>(std::ranges::lower_bound(at_home, id) - at_home.begin());
      });
    }
  });
  std::vector<std::uint64_t> numbers;
  for (const Bytes& bytes : told) {
    const auto list = MessageReader(bytes).get_view<std::uint64_t>();
    numbers.insert(numbers.end(), list.begin(), list.end());
  }
  return numbers;
}

}  // namespace tetloom
