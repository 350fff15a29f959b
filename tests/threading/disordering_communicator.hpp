#pragma once
// A communicator that delivers late and in any order.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include "tetloom/communicator.hpp"

namespace tetloom::test {

/// Wraps another communicator. About half of the messages are held back by a thread of its own, which sends one of
/// those it holds, chosen at random, now and then.
class DisorderingCommunicator : public Communicator {
 public:
  DisorderingCommunicator(Communicator& inner, std::uint32_t seed) : inner_(inner), random_(seed) {}

  int rank() const override { return inner_.rank(); }
  int rank_count() const override { return inner_.rank_count(); }
  int ranks_on_machine() const override { return inner_.ranks_on_machine(); }
  void open(Receiver receiver) override {
    inner_.open(std::move(receiver));
    closing_ = false;
    helper_ = std::thread([this] { send_held(); });
  }
  void send(Message&& message, int destination_rank) override {
    {
      const std::lock_guard lock(mutex_);
      if (random_() % 2 == 0) {
        held_.push_back({std::move(message), destination_rank});
        wake_.notify_one();
        return;
      }
    }
    inner_.send(std::move(message), destination_rank);
  }
  void close() override {
    {
      const std::lock_guard lock(mutex_);
      closing_ = true;
    }
    wake_.notify_one();
    helper_.join();
    inner_.close();
  }
  void sum(std::span<std::int64_t> values) override { inner_.sum(values); }
  void max(std::span<double> values) override { inner_.max(values); }
  std::vector<Bytes> all_gather(Bytes bytes) override { return inner_.all_gather(std::move(bytes)); }
  void announce_failure() override { inner_.announce_failure(); }
  bool failed_elsewhere() const override { return inner_.failed_elsewhere(); }

 private:
  void send_held() {
    std::unique_lock lock(mutex_);
    for (;;) {
      wake_.wait(lock, [this] { return closing_ || !held_.empty(); });
      if (held_.empty()) return;
      if (random_() % 4 == 0) {
        lock.unlock();
        std::this_thread::sleep_for(std::chrono::microseconds(50));
        lock.lock();
      }
      std::swap(held_[random_() % held_.size()], held_.back());
      auto [message, rank] = std::move(held_.back());
      held_.pop_back();
      lock.unlock();
      inner_.send(std::move(message), rank);
      lock.lock();
    }
  }

  Communicator& inner_;
  std::mutex mutex_;  // around all below but the thread
  std::mt19937 random_;
  std::condition_variable wake_;
  std::vector<std::pair<Message, int>> held_;
  bool closing_ = false;
  std::thread helper_;
};

}  // namespace tetloom::test
