#pragma once
// One computation that ranks carry out together: loops whose items are dealt to the ranks, after which all know all.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "tetloom/communicator.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// What a loop does with its items. Pre: what `make` makes of an item is the same on every rank.
struct SharedItems {
  std::function<void(std::size_t)> make;                  ///< on one rank, by any thread, several at once
  std::function<void(std::size_t, MessageWriter&)> put;   ///< on the same rank afterwards, one item after the other
  std::function<void(std::size_t, MessageReader&)> take;  ///< on all other ranks; the same values in the same order
};

/// The threads of this rank, and the ranks that share its work: none but this one where there is no communicator.
///
/// All ranks call `together` with the same work, and in there the same loops in the same order; between these each does
/// for itself what is not worth a message. Whatever a rank throws in there, inside or outside of loops, ends the call
/// on all ranks with the same Error: that of the lowest rank with one. Ranks inside a loop stop early then. A wish of
/// one rank's host to stop is such an error, of code Cancelled.
///
/// A small value; copies are the same. Thread safety: one call at a time.
class SharedWork {
 public:
  /// Not shared. Refers to `runner`.
  SharedWork(const TaskRunner& runner) : runner_(&runner) {}
  /// Shared with the ranks of `ranks`, where that is not null and has more than one. Refers to it, and to `trace`.
  SharedWork(int threads, const Host& host, Communicator* ranks, Trace* trace = nullptr);

  const TaskRunner& runner() const { return *runner_; }

  /// Errors: what `work` throws; where it is shared, an Error with the diagnostic of what one rank's work threw.
  void together(const std::function<void()>& work) const;

  /// Carries out all items, each on one rank, largest first. Pre: the same `work` on all ranks.
  void for_each(std::span<const double> work, const SharedItems& items) const;

  /// Calls body(begin, end) for blocks of at most `grain` values, which it fills in, and may do twice.
  template <class T>
  void fill(std::span<T> values, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) const;

  /// The lists that `make` makes, in the order of the items.
  template <class T>
  std::vector<std::vector<T>> make_lists(std::span<const double> work,
                                         const std::function<std::vector<T>(std::size_t)>& make) const;

  // What follows is for ranks that have something of their own; in `together` only.

  int rank() const;
  int rank_count() const;  ///< 1 where nothing is shared
  /// With the threads of all ranks on this machine: for what one of them does while the others wait.
  TaskRunner runner_for_one() const;
  /// Each rank does `work` of its own, with nothing of this class in it. Afterwards all have done theirs.
  void each(const std::function<void()>& work) const;
  /// Of what the ranks give, value by value.
  void sum(std::span<std::int64_t> values) const;
  void max(std::span<double> values) const;
  /// What each rank has put, by rank.
  std::vector<Bytes> all_gather(const std::function<void(MessageWriter&)>& put) const;
  /// Each rank puts something for every rank, this one among them; returns what was put for this one, by rank.
  std::vector<Bytes> exchange(const std::function<void(std::span<MessageWriter>)>& put) const;

 private:
  struct Ranks;

  bool is_shared() const { return ranks_ != nullptr; }
  void meet(const std::function<void()>& work) const;
  void agreed(const std::function<void(Communicator&)>& call) const;
  std::vector<std::size_t> own_items(std::span<const double> work, std::vector<int>& owners) const;
  void carry_out(std::span<const double> work, std::span<const std::size_t> own, const SharedItems& items) const;

  std::shared_ptr<Ranks> ranks_;
  std::shared_ptr<const TaskRunner> own_runner_;
  const TaskRunner* runner_;
};

template <class T>
void SharedWork::fill(std::span<T> values, std::size_t grain,
                      const std::function<void(std::size_t, std::size_t)>& body) const {
  const std::size_t blocks = (values.size() + grain - 1) / grain;
  // What takes no longer than a message does each rank for itself.
  if (!is_shared() || blocks < 2) return runner_->for_blocks(values.size(), grain, body);
  const auto block_of = [&](std::size_t block) {
    return values.subspan(block * grain, std::min(grain, values.size() - block * grain));
  };
  const std::vector<double> work(blocks, 1.0);
  for_each(work, {[&](std::size_t block) { body(block * grain, std::min(values.size(), (block + 1) * grain)); },
                  [&](std::size_t block, MessageWriter& writer) { writer.put_array<T>(block_of(block)); },
                  [&](std::size_t block, MessageReader& reader) {
                    const auto made = reader.get_view<T>();
                    std::copy(made.begin(), made.end(), block_of(block).begin());
                  }});
}

template <class T>
std::vector<std::vector<T>> SharedWork::make_lists(std::span<const double> work,
                                                   const std::function<std::vector<T>(std::size_t)>& make) const {
  std::vector<std::vector<T>> lists(work.size());
  for_each(work, {[&](std::size_t i) { lists[i] = make(i); },
                  [&](std::size_t i, MessageWriter& writer) { writer.put_array(std::span<const T>(lists[i])); },
                  [&](std::size_t i, MessageReader& reader) { lists[i] = reader.get_array<T>(); }});
  return lists;
}

}  // namespace tetloom
