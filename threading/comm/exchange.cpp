#include "threading/comm/exchange.hpp"

#include <algorithm>
#include <mutex>
#include <tuple>

namespace tetloom {
namespace {

// How many messages this rank will get.
std::size_t count_incoming(Communicator& communicator, const std::vector<Message>& outgoing,
                           const std::function<int(PartId)>& rank_of) {
  std::vector<std::int64_t> to_rank(static_cast<std::size_t>(communicator.rank_count()), 0);
  for (const Message& message : outgoing) ++to_rank[static_cast<std::size_t>(rank_of(message.to))];
  communicator.sum(to_rank);
  return static_cast<std::size_t>(to_rank[static_cast<std::size_t>(communicator.rank())]);
}

}  // namespace

std::vector<Message> exchange(Communicator& communicator, std::vector<Message> outgoing,
                              const std::function<int(PartId)>& rank_of) {
  std::vector<Message> arrived;
  arrived.reserve(count_incoming(communicator, outgoing, rank_of));
  std::mutex mutex;  // around `arrived`, which the communicator's own thread may fill
  communicator.open([&](Message&& message) {
    const std::lock_guard lock(mutex);
    if (message.to.valid()) arrived.push_back(std::move(message));
  });
  for (Message& message : outgoing) communicator.send(std::move(message), rank_of(message.to));
  communicator.close();
  std::sort(arrived.begin(), arrived.end(), [](const Message& a, const Message& b) {
    return std::tie(a.to, a.from, a.step) < std::tie(b.to, b.from, b.step);
  });
  return arrived;
}

}  // namespace tetloom
