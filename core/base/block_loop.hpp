#pragma once
// How functions of core carry out their long loops: block by block, by whoever calls them. Core knows of no threads.
#include <cstddef>
#include <functional>
#include <vector>

namespace tetloom {

/// Carries out loops over blocks of items. TaskRunner (threading/task_runner.hpp) is one on several threads.
class BlockLoop {
 public:
  virtual ~BlockLoop() = default;

  /// Calls body(begin, end) for blocks [begin, end) of [0, count), of at most `grain` items and cut at multiples of
  /// `grain`; in any order, and several at once. An exception of a body ends the loop and reaches the caller; bodies
  /// already running are finished first. May throw Error(Cancelled) of its own. Pre: grain > 0.
  virtual void for_blocks(std::size_t count, std::size_t grain,
                          const std::function<void(std::size_t, std::size_t)>& body) const = 0;
};

/// One block after the other, in their order, on the calling thread.
const BlockLoop& serial_loop();

/// Calls body(begin, end, result) for blocks as above, each with a copy of `blank` as its own result, and returns the
/// results in the order of the blocks: what is put together in that order does not depend on who carries out the loop.
template <class Result, class Body>
std::vector<Result> map_blocks(const BlockLoop& loop, std::size_t count, std::size_t grain, const Result& blank,
                               const Body& body) {
  std::vector<Result> results((count + grain - 1) / grain, blank);
  loop.for_blocks(count, grain, [&](std::size_t begin, std::size_t end) { body(begin, end, results[begin / grain]); });
  return results;
}

}  // namespace tetloom
