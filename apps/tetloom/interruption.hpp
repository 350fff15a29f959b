#pragma once
// Ctrl-C: asks the library to stop, and leaves without it when it does not.
#include <semaphore.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <thread>

#include "tetloom/host.hpp"

namespace tetloom::app {

/// While it lives, SIGINT, SIGTERM and SIGHUP raise `token()`. When the run is not over 0.9 s after the first signal,
/// or when a second one arrives, `leave` is called from a thread of its own and the process ends with exit status 5.
/// At most one object at a time.
class Interruption {
 public:
  /// `leave` removes what must not stay behind; it may not rely on the main thread, which may be stuck anywhere.
  explicit Interruption(std::function<void()> leave);
  /// Waits for a `leave` that has begun, which does not return.
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  const CancelToken& token() const;

 private:
  void watch();

  std::function<void()> leave_;
  // Set by the destructor before it posts the semaphore, read by watch() after waiting for it.
  std::atomic<bool> over_{false};
  std::thread watcher_;
};

/// Removes the temporaries that AtomicFile and AtomicFolder made in this process for `target`. For a process that is
/// about to end while another thread still writes.
void remove_temporaries_of(const std::filesystem::path& target);

}  // namespace tetloom::app
