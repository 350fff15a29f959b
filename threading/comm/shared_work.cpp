#include "threading/comm/shared_work.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <optional>
#include <utility>

#include "tetloom/tasks.hpp"
#include "threading/comm/agreement.hpp"
#include "threading/comm/exchange.hpp"

namespace tetloom {

struct SharedWork::Ranks {
  explicit Ranks(Communicator& given) : communicator(given) {}

  Communicator& communicator;
  // Raised around loops that ranks carry out together, read by whoever asks whether to go on; carries no data.
  std::atomic<bool> meeting{false};
  int depth = 0;        // of calls of `together`
  bool agreed = false;  // what is being thrown is being thrown on all ranks

  bool stopped() const { return meeting.load(std::memory_order_relaxed) && communicator.failed_elsewhere(); }
};

SharedWork::SharedWork(int threads, const Host& host, Communicator* ranks, Trace* trace) : runner_(nullptr) {
  Host listening = host;
  if (ranks != nullptr && ranks->rank_count() > 1) {
    ranks_ = std::make_shared<Ranks>(*ranks);
    listening.wants_stop = [given = host.wants_stop, shared = ranks_] {
      return (given && given()) || shared->stopped();
    };
  }
  own_runner_ = std::make_shared<TaskRunner>(threads, std::move(listening), trace);
  runner_ = own_runner_.get();
}

// Whatever happens on a rank, it comes to the next meeting of the others: those in `together` follow each other on all
// ranks alike, so that a rank that left early finds the others there. One `together` inside of another begins with a
// meeting, so that a rank that fails just before does not meet those who are inside already.
void SharedWork::together(const std::function<void()>& work) const {
  if (!is_shared()) return work();
  if (ranks_->depth > 0) meet([] {});
  ++ranks_->depth;
  ranks_->agreed = false;
  const std::optional<Diagnostic> failure = failure_of(work);
  --ranks_->depth;
  const bool agreed = failure && ranks_->agreed;
  const std::optional<Diagnostic> told = agreed ? failure : failure_of([&] {
    meet([&] {
      if (failure) throw Error(*failure);
    });
  });
  ranks_->agreed = false;
  if (told) throw Error(*told);
}

// Work that may fail on any rank, and does on all then. A rank that was stopped because another one failed has no
// failure of its own: whoever fails first has seen no other.
void SharedWork::meet(const std::function<void()>& work) const {
  Communicator& communicator = ranks_->communicator;
  communicator.open([](Message&&) {});
  ranks_->meeting = true;
  std::optional<Diagnostic> failure = failure_of(work);
  const bool is_first = !communicator.failed_elsewhere();
  ranks_->meeting = false;
  const bool is_own = failure && (failure->code != ErrorCode::Cancelled || is_first || runner_->cancelled());
  if (is_own) communicator.announce_failure();
  communicator.close();
  std::array<std::int64_t, 2> failures{is_own ? 1 : 0, failure ? 1 : 0};
  communicator.sum(failures);
  if (failures[1] == 0) return;
  ranks_->agreed = true;
  agree(communicator, is_own || failures[0] == 0 ? failure : std::nullopt);
}

// A collective call right after a meeting: from here on all ranks fail together or none does.
void SharedWork::agreed(const std::function<void(Communicator&)>& call) const {
  ranks_->agreed = true;
  call(ranks_->communicator);
  ranks_->agreed = false;
}

// Largest first, each to the rank that has least; the same on all ranks.
std::vector<std::size_t> SharedWork::own_items(std::span<const double> work, std::vector<int>& owners) const {
  const Communicator& communicator = ranks_->communicator;
  std::vector<std::size_t> order(work.size()), own;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return work[a] > work[b]; });
  std::vector<double> loads(static_cast<std::size_t>(communicator.rank_count()), 0.0);
  owners.resize(work.size());
  for (const std::size_t i : order) {
    const auto least = std::ranges::min_element(loads);
    *least += work[i];
    owners[i] = static_cast<int>(least - loads.begin());
    if (owners[i] == communicator.rank()) own.push_back(i);
  }
  return own;
}

void SharedWork::carry_out(std::span<const double> work, std::span<const std::size_t> own,
                           const SharedItems& items) const {
  std::vector<double> own_work;
  for (const std::size_t i : own) own_work.push_back(work[i]);
  runner_->for_each_largest_first(own_work, [&](std::size_t k) { items.make(own[k]); });
}

void SharedWork::for_each(std::span<const double> work, const SharedItems& items) const {
  if (!is_shared()) return runner_->for_each_largest_first(work, items.make);
  if (work.empty()) return;
  Communicator& communicator = ranks_->communicator;
  std::vector<int> owners;
  MessageWriter writer;
  meet([&] {
    const std::vector<std::size_t> own = own_items(work, owners);
    carry_out(work, own, items);
    for (std::size_t i = 0; i < work.size(); ++i)
      if (owners[i] == communicator.rank()) items.put(i, writer);
  });
  agreed([&](Communicator&) {
    const std::vector<Bytes> given = communicator.all_gather(writer.take());
    run_on_all(communicator, [&] {
      for (int from = 0; from < communicator.rank_count(); ++from) {
        if (from == communicator.rank()) continue;
        MessageReader reader(given[static_cast<std::size_t>(from)]);
        for (std::size_t i = 0; i < work.size(); ++i)
          if (owners[i] == from) items.take(i, reader);
      }
    });
  });
}

int SharedWork::rank() const { return is_shared() ? ranks_->communicator.rank() : 0; }

int SharedWork::rank_count() const { return is_shared() ? ranks_->communicator.rank_count() : 1; }

TaskRunner SharedWork::runner_for_one() const {
  return runner_->with_idle_threads(is_shared() ? ranks_->communicator.ranks_on_machine() : 1);
}

void SharedWork::each(const std::function<void()>& work) const {
  if (!is_shared()) return work();
  meet(work);
}

void SharedWork::sum(std::span<std::int64_t> values) const {
  if (!is_shared()) return;
  meet([] {});
  agreed([&](Communicator& communicator) { communicator.sum(values); });
}

void SharedWork::max(std::span<double> values) const {
  if (!is_shared()) return;
  meet([] {});
  agreed([&](Communicator& communicator) { communicator.max(values); });
}

std::vector<Bytes> SharedWork::all_gather(const std::function<void(MessageWriter&)>& put) const {
  MessageWriter writer;
  each([&] { put(writer); });
  std::vector<Bytes> given;
  if (!is_shared()) {
    given.push_back(writer.take());
  } else {
    agreed([&](Communicator& communicator) { given = communicator.all_gather(writer.take()); });
  }
  return given;
}

std::vector<Bytes> SharedWork::exchange(const std::function<void(std::span<MessageWriter>)>& put) const {
  const auto ranks = static_cast<std::size_t>(rank_count());
  std::vector<MessageWriter> writers(ranks);
  std::vector<Message> messages;
  std::vector<Bytes> given(ranks);
  each([&] {
    put(writers);
    const PartId self(static_cast<std::uint32_t>(rank()));
    for (std::uint32_t to = 0; to < ranks; ++to) messages.push_back({self, PartId(to), 0, writers[to].take()});
  });
  if (is_shared()) {
    agreed([&](Communicator& communicator) {
      messages = tetloom::exchange(communicator, std::move(messages),
                                   [](PartId rank) { return static_cast<int>(rank.value); });
    });
  }
  for (Message& message : messages) given[message.from.value] = std::move(message.bytes);
  return given;
}

}  // namespace tetloom
