#include "threading/comm/collectives.hpp"

#include <algorithm>
#include <array>
#include <mutex>
#include <tuple>

#include "core/base/codec.hpp"

namespace tetloom {
namespace {

// How many messages this rank will get.
std::size_t count_incoming(Communicator& communicator, const std::vector<Message>& outgoing,
                           const RankOfPart& rank_of) {
  std::vector<std::int64_t> to_rank(static_cast<std::size_t>(communicator.rank_count()), 0);
  for (const Message& message : outgoing) ++to_rank[static_cast<std::size_t>(rank_of(message.to))];
  communicator.sum(to_rank);
  return static_cast<std::size_t>(to_rank[static_cast<std::size_t>(communicator.rank())]);
}

}  // namespace

void agree(Communicator& communicator, const std::optional<Diagnostic>& failure) {
  std::array<std::int64_t, 1> failures{failure ? 1 : 0};
  communicator.sum(failures);
  if (failures[0] == 0) return;
  if (communicator.rank_count() == 1) throw Error(*failure);
  MessageWriter writer;
  if (failure) put_diagnostic(writer, *failure);
  for (const Bytes& bytes : communicator.all_gather(writer.take())) {
    if (bytes.empty()) continue;
    MessageReader reader(bytes);
    throw Error(get_diagnostic(reader));
  }
}

void run_on_all(Communicator& communicator, const std::function<void()>& work) {
  agree(communicator, failure_of(work));
}

void run_on_first(Communicator& communicator, const std::function<void()>& work) {
  agree(communicator, communicator.rank() == 0 ? failure_of(work) : std::nullopt);
}

std::uint64_t sum_over_ranks(Communicator& communicator, std::uint64_t value) {
  std::array<std::int64_t, 1> sum{static_cast<std::int64_t>(value)};
  communicator.sum(sum);
  return static_cast<std::uint64_t>(sum[0]);
}

std::uint64_t share_number(Communicator& communicator, std::uint64_t value) {
  return sum_over_ranks(communicator, communicator.rank() == 0 ? value : 0);
}

std::vector<Bytes> all_gather(Communicator& communicator, const Put& put) {
  MessageWriter writer;
  run_on_all(communicator, [&] { put(writer); });
  return communicator.all_gather(writer.take());
}

void gather(Communicator& communicator, const Put& put, const Take& take) {
  const std::vector<Bytes> given = all_gather(communicator, put);
  run_on_all(communicator, [&] {
    for (const Bytes& bytes : given) {
      MessageReader reader(bytes);
      take(reader);
    }
  });
}

void share_from_first(Communicator& communicator, const Put& put, const Take& take) {
  const std::vector<Bytes> given = all_gather(communicator, [&](MessageWriter& writer) {
    if (communicator.rank() == 0) put(writer);
  });
  run_on_all(communicator, [&] {
    MessageReader reader(given[0]);
    take(reader);
  });
}

std::vector<Bytes> exchange(Communicator& communicator, const PutForRanks& put) {
  const auto ranks = static_cast<std::size_t>(communicator.rank_count());
  const auto make = [&] {
    std::vector<MessageWriter> writers(ranks);
    put(writers);
    const PartId self(static_cast<std::size_t>(communicator.rank()));
    std::vector<Message> messages;
    for (std::size_t to = 0; to < ranks; ++to) messages.push_back({self, PartId(to), 0, writers[to].take()});
    return messages;
  };
  const auto rank_of = [](PartId rank) { return static_cast<int>(rank.value); };
  std::vector<Bytes> given(ranks);
  for (Message& message : exchange(communicator, make, rank_of)) given[message.from.value] = std::move(message.bytes);
  return given;
}

std::vector<Message> exchange(Communicator& communicator, const std::function<std::vector<Message>()>& make,
                              const RankOfPart& rank_of) {
  std::vector<Message> outgoing, arrived;
  run_on_all(communicator, [&] { outgoing = make(); });
  const std::size_t count = count_incoming(communicator, outgoing, rank_of);
  run_on_all(communicator, [&] { arrived.reserve(count); });
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
