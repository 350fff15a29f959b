#pragma once
// What a host hands to a long call and hears from it: progress, cancellation, and who carries out loops.
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/ids.hpp"

// What a long-running call tells its host, and how the host stops it.

namespace tetloom {

/// What a run is at; the order is that of a run.
enum class Stage {
  Read,
  SizeField,
  Edges,
  Faces,
  Intersections,
  Layers,
  Volume,
  SecondOrder,
  Partition,
  Adapt,
  Check,
  Write
};

std::string_view to_string(Stage stage);

/// One report of progress. `done` and `total` count the stage's own units (entities, triangles, tets, bytes);
/// `total` is 0 while it is unknown. `entity` is the one just finished, where that makes sense.
struct ProgressEvent {
  Stage stage = Stage::Read;
  ModelEntity entity;
  std::uint64_t done = 0;
  std::uint64_t total = 0;
};

/// Called by long-running functions, from any thread but never by two threads at once; returns false to cancel. It
/// must return quickly and must not throw.
using ProgressCallback = std::function<bool(const ProgressEvent&)>;

/// A flag that ends a long-running call within a second. May be raised from any thread and from a signal handler;
/// it must outlive the call.
class CancelToken {
 public:
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }
  /// Throws Error(Cancelled) once the flag is up.
  void check() const {
    if (cancelled()) throw Error(ErrorCode::Cancelled, "cancelled by the host");
  }

 private:
  // Written by cancel(), read by check() in the workers; carries no data, so relaxed order is enough.
  std::atomic<bool> cancelled_{false};
};

// How functions of core carry out their long loops: block by block, by whoever calls them. Core knows of no threads.

/// Carries out loops over blocks of items. TaskRunner (tetloom/tasks.hpp) is one on several threads.
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

/// What a host hands to a long-running call.
struct Host {
  ProgressCallback progress;            ///< may be empty
  const CancelToken* cancel = nullptr;  ///< may be null
  /// Asked wherever the call looks whether to go on: true ends it, like the token. Called from any thread, by several
  /// at once; it must be quick and must not throw. May be empty.
  std::function<bool()> wants_stop = {};
};

}  // namespace tetloom
