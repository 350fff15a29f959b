#include "bench/support/measured_ranks.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <stdexcept>

#include "threading/comm/simulated_ranks.hpp"
#include "threading/runtime/pausable.hpp"

// Ranks of one process share a heap: each would give back what the others are about to touch.
extern "C" int malloc_trim(std::size_t) noexcept { return 0; }

namespace tetloom::bench {
namespace {

class MeasuredRank final : public Communicator {
 public:
  explicit MeasuredRank(Communicator& given) : given_(given) { start(); }

  void start() {
    phases_.clear();
    sent_ = 0;
    since_ = Pausable::processor_seconds();
  }
  std::vector<RankPhase> take() {
    end_phase(0, false);
    return std::move(phases_);
  }

  int rank() const override { return given_.rank(); }
  int rank_count() const override { return given_.rank_count(); }
  std::uint64_t sent_bytes() const override { return sent_; }
  void open(Receiver receiver) override {
    measured([&] { given_.open(std::move(receiver)); });
  }
  void send(Message&& message, int destination_rank) override {
    if (destination_rank != rank()) sent_ += message.bytes.size();
    given_.send(std::move(message), destination_rank);
  }
  void close() override {
    measured([&] { given_.close(); });
  }
  void announce_failure() override { given_.announce_failure(); }
  bool failed_elsewhere() const override { return given_.failed_elsewhere(); }
  void sum(std::span<std::int64_t> values) override {
    measured([&] { given_.sum(values); });
  }
  void max(std::span<double> values) override {
    measured([&] { given_.max(values); });
  }
  std::vector<Bytes> all_gather(Bytes bytes) override {
    end_phase(rank_count() > 1 ? bytes.size() : 0, true);
    std::vector<Bytes> all = given_.all_gather(std::move(bytes));
    since_ = Pausable::processor_seconds();
    return all;
  }

 private:
  template <class Call>
  void measured(const Call& call) {
    end_phase(sent_.exchange(0), false);
    call();
    since_ = Pausable::processor_seconds();
  }
  void end_phase(std::uint64_t bytes, bool is_gathered) {
    phases_.push_back({Pausable::processor_seconds() - since_, bytes, is_gathered});
    since_ = Pausable::processor_seconds();
  }

  Communicator& given_;
  std::vector<RankPhase> phases_;
  std::atomic<std::uint64_t> sent_{0};  // in this phase
  double since_ = 0;
};

}  // namespace

RankPhases measure_ranks(int ranks,
                         const std::function<void(Communicator&, const std::function<void()>& start)>& body) {
  RankPhases phases(static_cast<std::size_t>(ranks));
  on_simulated_ranks(ranks, [&](Communicator& communicator) {
    MeasuredRank rank(communicator);
    body(rank, [&] { rank.start(); });
    phases[static_cast<std::size_t>(rank.rank())] = rank.take();
  });
  for (const auto& of_rank : phases)
    if (of_rank.size() != phases[0].size()) throw std::logic_error("ranks have different numbers of collective calls");
  return phases;
}

double predict_seconds(const RankPhases& phases, const NetworkCosts& network) {
  const double hops = phases.size() < 2 ? 0 : std::bit_width(phases.size() - 1);
  double seconds = compute_seconds(phases);
  for (std::size_t p = 0; p < phases[0].size(); ++p) {
    std::uint64_t most = 0, all = 0;
    for (const auto& of_rank : phases) most = std::max(most, of_rank[p].bytes), all += of_rank[p].bytes;
    const std::uint64_t bytes = phases[0][p].is_gathered ? all : most;
    seconds += hops * network.latency + (hops > 0 ? static_cast<double>(bytes) / network.bandwidth : 0);
  }
  return seconds;
}

double compute_seconds(const RankPhases& phases) {
  double seconds = 0;
  for (std::size_t p = 0; p < phases[0].size(); ++p) {
    double longest = 0;
    for (const auto& of_rank : phases) longest = std::max(longest, of_rank[p].seconds);
    seconds += longest;
  }
  return seconds;
}

double processor_seconds(const RankPhases& phases) {
  double seconds = 0;
  for (const auto& of_rank : phases)
    for (const RankPhase& phase : of_rank) seconds += phase.seconds;
  return seconds;
}

std::uint64_t most_sent_bytes(const RankPhases& phases) {
  std::uint64_t most = 0;
  for (const auto& of_rank : phases) {
    std::uint64_t sent = 0;
    for (const RankPhase& phase : of_rank) sent += phase.bytes;
    most = std::max(most, sent);
  }
  return most;
}

}  // namespace tetloom::bench
