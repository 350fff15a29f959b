#pragma once
// Loops that carry out blocks otherwise than the serial one, for tests of what must not depend on that.
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

#include "tetloom/host.hpp"

namespace tetloom::test {

/// The last block first.
class BackwardsLoop : public BlockLoop {
 public:
  void for_blocks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) const override {
    for (std::size_t block = (count + grain - 1) / grain; block-- > 0;)
      body(block * grain, std::min(count, (block + 1) * grain));
  }
};

/// On a number of threads of their own.
class ThreadsLoop : public BlockLoop {
 public:
  explicit ThreadsLoop(std::size_t threads) : threads_(threads) {}
  void for_blocks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) const override {
    std::atomic<std::size_t> next{0};  // counts blocks taken; each goes to the thread that took it
    std::vector<std::exception_ptr> thrown(threads_);
    const auto run = [&](std::size_t thread) {
      try {
        for (std::size_t begin; (begin = next.fetch_add(1) * grain) < count;)
          body(begin, std::min(count, begin + grain));
      } catch (...) {
        thrown[thread] = std::current_exception();
        next.store(count);
      }
    };
    {
      std::vector<std::jthread> threads;
      for (std::size_t thread = 0; thread < threads_; ++thread) threads.emplace_back(run, thread);
    }
    for (const std::exception_ptr& error : thrown)
      if (error) std::rethrow_exception(error);
  }

 private:
  std::size_t threads_;
};

}  // namespace tetloom::test
