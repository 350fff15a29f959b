#include "apps/tetloom/interruption.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <string>
#include <utility>

#include "apps/tetloom/exit_status.hpp"

namespace tetloom::app {
namespace {

constexpr long kPatienceNanoseconds = 900'000'000;
constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

// What a signal handler may touch: both outlive every Interruption.
CancelToken cancel_token;
sem_t wake_up;

extern "C" void on_signal(int) {
  const int saved = errno;
  cancel_token.cancel();
  ::sem_post(&wake_up);
  errno = saved;
}

/// False once `patience` is over.
bool wait_for_wake_up(const timespec* deadline) {
  int result = 0;
  do {
    result = deadline != nullptr ? ::sem_clockwait(&wake_up, CLOCK_MONOTONIC, deadline) : ::sem_wait(&wake_up);
  } while (result != 0 && errno == EINTR);
  return result == 0;
}

timespec end_of_patience() {
  timespec time{};
  ::clock_gettime(CLOCK_MONOTONIC, &time);
  time.tv_nsec += kPatienceNanoseconds;
  time.tv_sec += time.tv_nsec / 1'000'000'000;
  time.tv_nsec %= 1'000'000'000;
  return time;
}

void install_handlers() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESTART;
  ::sigemptyset(&action.sa_mask);
  for (const int signal : kSignals) {
    struct sigaction before {};
    ::sigaction(signal, nullptr, &before);
    // nohup asks for SIGHUP to be ignored; shells ignore SIGINT for background jobs, where it still means "stop".
    if (signal == SIGHUP && before.sa_handler == SIG_IGN) continue;
    ::sigaction(signal, &action, nullptr);
  }
}

}  // namespace

Interruption::Interruption(std::function<void()> leave) : leave_(std::move(leave)) {
  ::sem_init(&wake_up, 0, 0);
  install_handlers();
  watcher_ = std::thread(&Interruption::watch, this);
}

Interruption::~Interruption() {
  over_.store(true, std::memory_order_relaxed);
  ::sem_post(&wake_up);
  watcher_.join();
  // A signal from here on finds a run that is over: it ends the process as if there had been no handler.
  for (const int signal : kSignals) std::signal(signal, SIG_DFL);
}

const CancelToken& Interruption::token() const { return cancel_token; }

void Interruption::watch() {
  wait_for_wake_up(nullptr);
  if (over_.load(std::memory_order_relaxed)) return;
  const timespec deadline = end_of_patience();
  wait_for_wake_up(&deadline);
  if (over_.load(std::memory_order_relaxed)) return;
  leave_();
  ::_exit(static_cast<int>(ExitStatus::Cancelled));
}

void remove_temporaries_of(const std::filesystem::path& target) {
  std::error_code error;
  // As AtomicFile does it: a link stays, and the file behind it is replaced.
  const bool is_link = std::filesystem::is_symlink(target, error);
  const std::filesystem::path file = is_link ? std::filesystem::canonical(target, error) : target;
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  // ".<name>.<process>-<number>.tmp".
  const std::string begin = "." + file.filename().string().substr(0, 200) + "." + std::to_string(::getpid()) + "-";
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(begin) && name.ends_with(".tmp")) {
      std::error_code ignored;
      std::filesystem::remove_all(entry->path(), ignored);
    }
  }
}

}  // namespace tetloom::app
