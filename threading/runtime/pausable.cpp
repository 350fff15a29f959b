#include "threading/runtime/pausable.hpp"

#include <time.h>

#include <utility>

namespace tetloom {

namespace {

thread_local double seconds_elsewhere = 0;

double thread_seconds() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

thread_local Pausable* Pausable::here_ = nullptr;

Pausable::~Pausable() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    left_ = works_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool Pausable::resume() {
  std::unique_lock lock(mutex_);
  if (ended_) return true;
  const double before = seconds_;
  works_ = true;
  if (!thread_.joinable())
    thread_ = std::thread([this] { run(); });
  else
    changed_.notify_all();
  changed_.wait(lock, [this] { return !works_; });
  seconds_elsewhere += seconds_ - before;
  if (!ended_) return false;
  lock.unlock();
  thread_.join();
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
  return true;
}

void Pausable::pause() {
  Pausable& self = *here_;
  std::unique_lock lock(self.mutex_);
  self.works_ = false, self.seconds_ = thread_seconds();
  self.changed_.notify_all();
  self.changed_.wait(lock, [&] { return self.works_; });
  if (self.left_) throw Left();
}

double Pausable::processor_seconds() { return thread_seconds() + seconds_elsewhere; }

void Pausable::run() noexcept {
  here_ = this;
  std::exception_ptr error;
  try {
    work_();
  } catch (const Left&) {
  } catch (...) {
    error = std::current_exception();
  }
  const std::lock_guard lock(mutex_);
  error_ = error;
  ended_ = true, works_ = false, seconds_ = thread_seconds();
  changed_.notify_all();
}

}  // namespace tetloom
