#pragma once
// Ranks as threads of this process: for tests of collective calls, and to predict what many ranks would take.
#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

#include "tetloom/communicator.hpp"

namespace tetloom {

/// Where threads wait for each other asleep: std::barrier tries for a while first, and takes the cores from those that
/// are still at work.
class MeetingPoint {
 public:
  explicit MeetingPoint(int threads) : threads_(threads) {}

  void arrive_and_wait() {
    std::unique_lock lock(mutex_);
    const std::size_t meeting = meetings_;
    if (++arrived_ < threads_) return all_are_there_.wait(lock, [&] { return meetings_ != meeting; });
    arrived_ = 0, ++meetings_;
    all_are_there_.notify_all();
  }

 private:
  const int threads_;
  std::mutex mutex_;
  std::condition_variable all_are_there_;
  int arrived_ = 0;
  std::size_t meetings_ = 0;
};

/// Messages are handed over by the sender.
class SimulatedRank : public Communicator {
 public:
  struct Board {
    explicit Board(int ranks) : barrier(ranks), receivers(ranks), sums(ranks), maxima(ranks), given(ranks) {}
    MeetingPoint barrier;
    std::vector<Receiver> receivers;  // written between barriers
    std::atomic<bool> failed{false};  // raised by a rank that fails in a run, read by all others in it; carries no data
    std::vector<std::span<std::int64_t>> sums;
    std::vector<std::span<double>> maxima;
    std::vector<Bytes> given;
  };

  SimulatedRank(Board& board, int rank) : board_(board), rank_(rank) {}
  int rank() const override { return rank_; }
  int rank_count() const override { return static_cast<int>(board_.given.size()); }
  void open(Receiver receiver) override {
    board_.receivers[rank_] = std::move(receiver);
    has_failed_ = false;
    if (rank_ == 0) board_.failed = false;
    board_.barrier.arrive_and_wait();
  }
  void send(Message&& message, int destination_rank) override {
    board_.receivers[destination_rank](std::move(message));
  }
  void close() override {
    board_.barrier.arrive_and_wait();
    board_.receivers[rank_] = nullptr;
    board_.barrier.arrive_and_wait();
  }
  void announce_failure() override { has_failed_ = true, board_.failed = true; }
  bool failed_elsewhere() const override { return board_.failed && !has_failed_; }

  void sum(std::span<std::int64_t> values) override {
    // As MPI does: sums of hashes go round.
    combine(board_.sums, values, std::int64_t{0}, [](std::int64_t a, std::int64_t b) {
      return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
    });
  }
  void max(std::span<double> values) override {
    combine(board_.maxima, values, -std::numeric_limits<double>::infinity(),
            [](double a, double b) { return std::max(a, b); });
  }
  std::vector<Bytes> all_gather(Bytes bytes) override {
    board_.given[rank_] = std::move(bytes);
    board_.barrier.arrive_and_wait();
    auto all = board_.given;
    board_.barrier.arrive_and_wait();
    return all;
  }

 private:
  template <class T, class Combine>
  void combine(std::vector<std::span<T>>& board, std::span<T> values, T start, Combine combine) {
    board[rank_] = values;
    board_.barrier.arrive_and_wait();
    std::vector<T> result(values.size(), start);
    for (const std::span<T> one : board)
      for (std::size_t i = 0; i < result.size(); ++i) result[i] = combine(result[i], one[i]);
    board_.barrier.arrive_and_wait();
    std::copy(result.begin(), result.end(), values.begin());
    board_.barrier.arrive_and_wait();
  }

  Board& board_;
  int rank_;
  std::atomic<bool> has_failed_{false};  // asked by any thread of the rank that sets it
};

/// Runs body once for each rank, all at the same time. Rethrows what the lowest rank threw that threw anything; all
/// ranks must throw alike, or the others wait for ever.
inline void on_simulated_ranks(int ranks, const std::function<void(Communicator&)>& body) {
  SimulatedRank::Board board(ranks);
  std::vector<std::exception_ptr> thrown(ranks);
  {
    std::vector<std::jthread> threads;
    for (int r = 0; r < ranks; ++r)
      threads.emplace_back([&, r] {
        SimulatedRank rank(board, r);
        try {
          body(rank);
        } catch (...) {
          thrown[r] = std::current_exception();
        }
      });
  }
  for (const std::exception_ptr& error : thrown)
    if (error) std::rethrow_exception(error);
}

}  // namespace tetloom
