#pragma once
// What a long-running call tells its host, and how the host stops it.
#include <atomic>
#include <cstdint>
#include <functional>
#include <string_view>

#include "core/base/error.hpp"
#include "core/base/ids.hpp"

namespace tetloom {

enum class Stage { Read, SizeField, Edges, Faces, Intersections, Volume, Partition, Adapt, Check, Write };

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

}  // namespace tetloom
