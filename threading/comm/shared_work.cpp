#include "threading/comm/shared_work.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <optional>
#include <utility>

#include "tetloom/tasks.hpp"

namespace tetloom {

/// The ranks of a communicator, which meet before each collective call. Whatever happens on a rank, it comes to the
/// next meeting of the others: in `together` all ranks have the same meetings, and one that left early finds the others
/// at the next of theirs.
class SharedWork::MeetingRanks final : public Communicator, public std::enable_shared_from_this<MeetingRanks> {
 public:
  explicit MeetingRanks(Communicator& given) : given_(given) {}

  int rank() const override { return given_.rank(); }
  int rank_count() const override { return given_.rank_count(); }
  int ranks_on_machine() const override { return given_.ranks_on_machine(); }
  std::uint64_t sent_bytes() const override { return given_.sent_bytes(); }
  std::optional<int> mpi_handle() const override { return given_.mpi_handle(); }

  void open(Receiver receiver) override {
    meet();
    given_.open(std::move(receiver));
  }
  void send(Message&& message, int destination_rank) override { given_.send(std::move(message), destination_rank); }
  void close() override { given_.close(); }
  void announce_failure() override { given_.announce_failure(); }
  bool failed_elsewhere() const override { return given_.failed_elsewhere(); }

  void sum(std::span<std::int64_t> values) override {
    meet();
    given_.sum(values);
  }
  void max(std::span<double> values) override {
    meet();
    given_.max(values);
  }
  std::vector<Bytes> all_gather(Bytes bytes) override {
    meet();
    return given_.all_gather(std::move(bytes));
  }

  void meet() {
    meet([] {}, [] { return false; });
  }
  void meet(const std::function<void()>& work, const std::function<bool()>& cancelled);
  Communicator& given() const { return given_; }
  bool stopped() const { return meeting_.load(std::memory_order_relaxed) && given_.failed_elsewhere(); }

  int depth = 0;  ///< of calls of `together`
  /// What is being thrown was told in a meeting: the others leave `together`, too, and have no further meeting in
  /// there.
  bool agreed = false;

 private:
  Communicator& given_;
  // Raised around what ranks do in a meeting, read by whoever asks whether to go on; carries no data.
  std::atomic<bool> meeting_{false};
};

// Work that may fail on any rank, and does on all then. A rank that was stopped because another one failed has no
// failure of its own: whoever fails first has seen no other.
void SharedWork::MeetingRanks::meet(const std::function<void()>& work, const std::function<bool()>& cancelled) {
  agreed = false;
  given_.open([](Message&&) {});
  meeting_ = true;
  const std::optional<Diagnostic> failure = failure_of(work);
  const bool is_first = !given_.failed_elsewhere();
  meeting_ = false;
  const bool is_own = failure && (failure->code != ErrorCode::Cancelled || is_first || cancelled());
  if (is_own) given_.announce_failure();
  given_.close();
  std::array<std::int64_t, 2> failures{is_own ? 1 : 0, failure ? 1 : 0};
  given_.sum(failures);
  agreed = failures[1] != 0;
  if (agreed) agree(given_, is_own || failures[0] == 0 ? failure : std::nullopt);
}

SharedWork::SharedWork(const TaskRunner& runner) : communicator_(make_thread_communicator()), runner_(&runner) {}

SharedWork::SharedWork(int threads, const Host& host, Communicator* ranks, Trace* trace) : runner_(nullptr) {
  Host listening = host;
  if (ranks == nullptr) {
    communicator_ = make_thread_communicator();
  } else if (ranks->rank_count() == 1) {
    communicator_ = std::shared_ptr<Communicator>(std::shared_ptr<void>(), ranks);
  } else {
    auto* const known = dynamic_cast<MeetingRanks*>(ranks);  // inside of other work that they share
    const auto shared = known != nullptr ? known->shared_from_this() : std::make_shared<MeetingRanks>(*ranks);
    shared_ = shared.get();
    communicator_ = shared;
    listening.wants_stop = [given = host.wants_stop, shared] { return (given && given()) || shared->stopped(); };
  }
  own_runner_ = std::make_shared<TaskRunner>(threads, std::move(listening), trace);
  runner_ = own_runner_.get();
}

// One `together` inside of another begins with a meeting, so that a rank that fails just before does not meet those who
// are inside already. Each ends with one: for a rank that fails, wherever the others are, it is their next one.
void SharedWork::together(const std::function<void()>& work) const {
  if (is_shared() && shared_->depth > 0) shared_->meet();
  if (is_shared()) ++shared_->depth, shared_->agreed = false;
  std::optional<Diagnostic> failure = failure_of(work);
  if (is_shared()) {
    --shared_->depth;
    const auto tell = [&] {
      if (failure) throw Error(*failure);
    };
    if (!failure || !shared_->agreed) failure = failure_of([&] { meet(tell); });
    shared_->agreed = false;
  }
  if (failure) throw Error(*failure);
}

// For a collective call right after a meeting.
Communicator& SharedWork::after_meeting() const { return is_shared() ? shared_->given() : *communicator_; }

void SharedWork::meet(const std::function<void()>& work) const {
  shared_->meet(work, [&] { return runner_->cancelled(); });
}

// The rank of each item: largest first, each to the rank that has least; the same on all ranks.
std::vector<int> SharedWork::deal(std::span<const double> work) const {
  std::vector<std::size_t> order(work.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return work[a] > work[b]; });
  std::vector<double> loads(static_cast<std::size_t>(communicator_->rank_count()), 0.0);
  std::vector<int> owners(work.size());
  for (const std::size_t i : order) {
    const auto least = std::ranges::min_element(loads);
    *least += work[i];
    owners[i] = static_cast<int>(least - loads.begin());
  }
  return owners;
}

void SharedWork::carry_out(std::span<const double> work, std::span<const std::size_t> own,
                           const SharedItems& items) const {
  std::vector<double> own_work;
  for (const std::size_t i : own) own_work.push_back(work[i]);
  runner_->for_each_largest_first(own_work, [&](std::size_t k) { items.make(own[k]); });
}

void SharedWork::for_each(std::span<const double> work, const SharedItems& items) const {
  if (!is_shared()) return runner_->for_each_largest_first(work, items.make);
  if (!work.empty()) for_each(work, deal(work), items);
}

void SharedWork::for_each(std::span<const double> work, std::span<const int> owners, const SharedItems& items) const {
  const std::vector<Bytes> given = all_gather([&](MessageWriter& writer) {
    std::vector<std::size_t> own;
    for (std::size_t i = 0; i < work.size(); ++i)
      if (owners[i] == rank()) own.push_back(i);
    carry_out(work, own, items);
    for (const std::size_t i : own) items.put(i, writer);
  });
  each([&] {
    for (int from = 0; from < rank_count(); ++from) {
      if (from == rank()) continue;
      MessageReader reader(given[static_cast<std::size_t>(from)]);
      for (std::size_t i = 0; i < work.size(); ++i)
        if (owners[i] == from) items.take(i, reader);
    }
  });
}

void SharedWork::each(const std::function<void()>& work) const { is_shared() ? meet(work) : work(); }

void SharedWork::sum(std::span<ExactSum> values) const {
  std::vector<std::int64_t> words;
  for (ExactSum& value : values) {
    value.carry();
    words.insert(words.end(), value.words().begin(), value.words().end());
  }
  sum(words);
  auto next = words.cbegin();
  for (ExactSum& value : values) {
    for (std::int64_t& word : value.words()) word = *next++;
    value.carry();
  }
}

std::vector<Bytes> SharedWork::all_gather(const Put& put) const {
  MessageWriter writer;
  each([&] { put(writer); });
  return after_meeting().all_gather(writer.take());
}

std::vector<Bytes> SharedWork::exchange(const PutForRanks& put) const {
  std::vector<MessageWriter> writers(static_cast<std::size_t>(rank_count()));
  each([&] { put(writers); });
  return tetloom::exchange(after_meeting(),
                           [&](std::span<MessageWriter> to) { std::ranges::move(writers, to.begin()); });
}

}  // namespace tetloom
