#pragma once
// One computation that ranks carry out together: loops whose items are dealt to the ranks, after which all know all.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/base/exact_sum.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {

/// What a loop does with its items. Pre: what `make` makes of an item is the same on every rank.
struct SharedItems {
  std::function<void(std::size_t)> make;                  ///< on one rank, by any thread, several at once
  std::function<void(std::size_t, MessageWriter&)> put;   ///< on the same rank afterwards, one item after the other
  std::function<void(std::size_t, MessageReader&)> take;  ///< on all other ranks; the same values in the same order
};

/// The threads of this rank, and the ranks that share its work: none but this one where there is no communicator.
///
/// All ranks call `together` with the same work, and in there the same loops and collective calls in the same order;
/// between these each does for itself what is not worth a message. Whatever a rank throws in there, of any type, inside
/// or outside of loops, ends the call on all ranks with the same Error: that of the lowest rank with one. Ranks inside
/// a loop stop early then. A wish of one rank's host to stop is such an error, of code Cancelled.
///
/// A small value; copies are the same. Thread safety: one call at a time.
class SharedWork {
 public:
  /// Not shared. Refers to `runner`.
  SharedWork(const TaskRunner& runner);
  /// Shared with the ranks of `ranks`, where that is not null and has more than one. Refers to it, and to `trace`.
  SharedWork(int threads, const Host& host, Communicator* ranks, Trace* trace = nullptr);

  const TaskRunner& runner() const { return *runner_; }

  /// Errors: what failure_of says of `work`, of the lowest rank where it says something.
  void together(const std::function<void()>& work) const;

  /// A rank for each item, largest first, so that all have about equal work. Pre: there are ranks, with the same
  /// `work`.
  std::vector<int> deal(std::span<const double> work) const;
  /// Carries out all items, each on one rank, largest first. Pre: the same `work` on all ranks.
  void for_each(std::span<const double> work, const SharedItems& items) const;

  /// Calls body(begin, end) for blocks of at most `grain` values, which it fills in, and may do twice.
  template <class T>
  void fill(std::span<T> values, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) const;

  /// The same, where the rank `owner_of(i)` fills in value i, and consecutive values of one owner are a block. All
  /// ranks fill in what is no more than `grain` values.
  template <class T>
  void fill(std::span<T> values, std::size_t grain, const std::function<int(std::size_t)>& owner_of,
            const std::function<void(std::size_t, std::size_t)>& body) const;

  /// The lists that `make` makes, in the order of the items.
  template <class T>
  std::vector<std::vector<T>> make_lists(std::span<const double> work,
                                         const std::function<std::vector<T>(std::size_t)>& make) const;

  // What follows is for ranks that have something of their own; in `together` only.

  /// For collective calls, schedules and meshes in parts. Each call of it that is collective first finds out whether a
  /// rank has failed since the last one, and throws the same Error on all ranks then. Valid as long as this is.
  Communicator& ranks() const { return *communicator_; }
  int rank() const { return ranks().rank(); }
  int rank_count() const { return ranks().rank_count(); }  ///< 1 where nothing is shared
  /// With the threads of all ranks on this machine: for what one of them does while the others wait.
  TaskRunner runner_for_one() const { return runner_->with_idle_threads(ranks().ranks_on_machine()); }
  /// Each rank does `work` of its own, with nothing of this class in it. Afterwards all have done theirs. As
  /// run_on_all, with loops of `runner()` that stop early where another rank fails.
  void each(const std::function<void()>& work) const;
  /// As in collectives.hpp, where `put` stops early, too.
  void sum(std::span<std::int64_t> values) const { ranks().sum(values); }
  void sum(std::span<ExactSum> values) const;
  void max(std::span<double> values) const { ranks().max(values); }
  std::vector<Bytes> all_gather(const Put& put) const;
  std::vector<Bytes> exchange(const PutForRanks& put) const;

 private:
  class MeetingRanks;

  bool is_shared() const { return shared_ != nullptr; }
  void meet(const std::function<void()>& work) const;
  Communicator& after_meeting() const;
  void for_each(std::span<const double> work, std::span<const int> owners, const SharedItems& items) const;
  template <class T>
  void fill_blocks(std::span<T> values, std::span<const std::size_t> begins, std::span<const int> owners,
                   const std::function<void(std::size_t, std::size_t)>& body) const;
  void carry_out(std::span<const double> work, std::span<const std::size_t> own, const SharedItems& items) const;

  std::shared_ptr<Communicator> communicator_;
  MeetingRanks* shared_ = nullptr;  // the same, where there are several
  std::shared_ptr<const TaskRunner> own_runner_;
  const TaskRunner* runner_;
};

template <class T>
void SharedWork::fill(std::span<T> values, std::size_t grain,
                      const std::function<void(std::size_t, std::size_t)>& body) const {
  const std::size_t blocks = (values.size() + grain - 1) / grain;
  // What takes no longer than a message does each rank for itself.
  if (!is_shared() || blocks < 2) return runner_->for_blocks(values.size(), grain, body);
  std::vector<std::size_t> begins;
  for (std::size_t begin = 0; begin < values.size(); begin += grain) begins.push_back(begin);
  fill_blocks<T>(values, begins, {}, body);
}

template <class T>
void SharedWork::fill(std::span<T> values, std::size_t grain, const std::function<int(std::size_t)>& owner_of,
                      const std::function<void(std::size_t, std::size_t)>& body) const {
  if (!is_shared() || values.size() <= grain) return runner_->for_blocks(values.size(), grain, body);
  std::vector<std::size_t> begins;
  std::vector<int> owners;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int owner = owner_of(i);
    if (!owners.empty() && owners.back() == owner) continue;
    begins.push_back(i), owners.push_back(owner);
  }
  fill_blocks<T>(values, begins, owners, body);
}

// In rounds, so that messages are small beside the values.
template <class T>
void SharedWork::fill_blocks(std::span<T> values, std::span<const std::size_t> begins, std::span<const int> owners,
                             const std::function<void(std::size_t, std::size_t)>& body) const {
  constexpr std::size_t kLeastOfRound = std::size_t{1} << 19, kOfRank = std::size_t{1} << 14;  // bytes
  const std::size_t of_round = std::max(kLeastOfRound, kOfRank * static_cast<std::size_t>(rank_count())) / sizeof(T);
  const auto begin_of = [&](std::size_t block) { return block < begins.size() ? begins[block] : values.size(); };
  for (std::size_t first = 0, last = 0; first < begins.size(); first = last) {
    while (last < begins.size() && (last == first || begin_of(last + 1) - begins[first] <= of_round)) ++last;
    std::vector<double> work;
    for (std::size_t block = first; block < last; ++block)
      work.push_back(static_cast<double>(begin_of(block + 1) - begins[block]));
    const auto block_of = [&](std::size_t i) {
      return values.subspan(begins[first + i], begin_of(first + i + 1) - begins[first + i]);
    };
    for_each(work, owners.empty() ? deal(work) : std::vector(owners.begin() + first, owners.begin() + last),
             {[&](std::size_t i) { body(begins[first + i], begin_of(first + i + 1)); },
              [&](std::size_t i, MessageWriter& writer) { writer.put_array<T>(block_of(i)); },
              [&](std::size_t i, MessageReader& reader) {
                const auto made = reader.get_view<T>();
                std::copy(made.begin(), made.end(), block_of(i).begin());
              }});
  }
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
