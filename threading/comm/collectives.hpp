#pragma once
// What ranks do together outside of schedules, over any Communicator. All functions are collective calls.
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/base/failure.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/error.hpp"

namespace tetloom {

// One outcome for all ranks, where each has work of its own that may fail. Such work makes no collective calls.

/// Throws what the lowest rank gave that gave an error, on all ranks alike; returns when none did.
void agree(Communicator& communicator, const std::optional<Diagnostic>& failure);
/// Calls `work` and agrees on what failure_of says of it.
void run_on_all(Communicator& communicator, const std::function<void()>& work);
/// The same on rank 0 alone.
void run_on_first(Communicator& communicator, const std::function<void()>& work);

// What ranks tell each other. Callbacks are run as by run_on_all.

using Put = std::function<void(MessageWriter&)>;
using PutForRanks = std::function<void(std::span<MessageWriter>)>;  ///< one writer for each rank
using Take = std::function<void(MessageReader&)>;
using RankOfPart = std::function<int(PartId)>;

/// The sum of what the ranks give, modulo 2⁶⁴.
std::uint64_t sum_over_ranks(Communicator& communicator, std::uint64_t value);
/// The number that rank 0 gives.
std::uint64_t share_number(Communicator& communicator, std::uint64_t value);
/// What each rank has put, by rank.
std::vector<Bytes> all_gather(Communicator& communicator, const Put& put);
/// Calls `take` for what each rank has put, by rank, on all ranks.
void gather(Communicator& communicator, const Put& put, const Take& take);
/// The lists with which messages begin, one after the other.
template <class T>
std::vector<T> joined_lists(std::span<const Bytes> messages) {
  std::vector<T> all;
  for (const Bytes& bytes : messages) {
    const auto list = MessageReader(bytes).get_view<T>();
    all.insert(all.end(), list.begin(), list.end());
  }
  return all;
}
/// The lists of all ranks, one after the other.
template <class T>
std::vector<T> gather_lists(Communicator& communicator, std::span<const T> own) {
  return joined_lists<T>(all_gather(communicator, [&](MessageWriter& writer) { writer.put_array<T>(own); }));
}
/// `put` on rank 0, `take` on all.
void share_from_first(Communicator& communicator, const Put& put, const Take& take);
/// What all ranks have put for this one, by rank.
std::vector<Bytes> exchange(Communicator& communicator, const PutForRanks& put);
/// Delivers every message of those that `make` makes to the rank that `rank_of` names for its destination, and returns
/// those for this rank, ascending by destination, then sender, then `step`. Bytes are moved where they stay on the
/// rank.
std::vector<Message> exchange(Communicator& communicator, const std::function<std::vector<Message>()>& make,
                              const RankOfPart& rank_of);

}  // namespace tetloom
