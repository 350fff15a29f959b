#include "bench/support/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "bench/support/machine.hpp"

namespace tetloom::bench {
namespace {

/// The child's side of a pipe as its standard output and error.
class SpawnActions {
 public:
  explicit SpawnActions(int output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, output, STDERR_FILENO);
  }
  ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

/// What is known of a process's memory while it runs.
class MemoryWatch {
 public:
  explicit MemoryWatch(pid_t process) : status_("/proc/" + std::to_string(process) + "/status") {}

  void look() {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_ < kInterval) return;
    last_ = now;
    const ProcessMemory memory = read_process_memory(status_);
    peak_ = std::max(peak_, memory.peak);
    swap_ = std::max(swap_, memory.swapped);
  }
  std::uint64_t peak() const { return peak_; }
  std::uint64_t swap() const { return swap_; }

  static constexpr std::chrono::milliseconds kInterval{20};

 private:
  std::string status_;
  std::chrono::steady_clock::time_point last_;
  std::uint64_t peak_ = 0, swap_ = 0;
};

/// Whether a new process leads a group of its own.
class SpawnGroup {
 public:
  explicit SpawnGroup(bool own) {
    posix_spawnattr_init(&attributes_);
    if (own) posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP);
  }
  ~SpawnGroup() { posix_spawnattr_destroy(&attributes_); }
  SpawnGroup(const SpawnGroup&) = delete;
  SpawnGroup& operator=(const SpawnGroup&) = delete;
  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

/// Ends a group of processes whose time is up: asks first, then kills.
class Deadline {
 public:
  Deadline(pid_t group, const ChildLimit& limit) : group_(group), limit_(limit) {}

  void look() {
    if (limit_.seconds <= 0) return;
    const double passed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    if (!asked_ && passed >= limit_.seconds) {
      asked_ = true;
      kill(-group_, SIGINT);
    }
    if (asked_ && !killed_ && passed >= limit_.seconds + limit_.grace) {
      killed_ = true;
      kill(-group_, SIGKILL);
    }
  }
  bool passed() const { return asked_; }

 private:
  pid_t group_;
  ChildLimit limit_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  bool asked_ = false, killed_ = false;
};

std::string read_to_end(int file, MemoryWatch& watch, Deadline& deadline) {
  std::string text;
  std::array<char, 4096> buffer;
  for (;;) {
    watch.look();
    deadline.look();
    pollfd wanted{file, POLLIN, 0};
    const int ready = poll(&wanted, 1, static_cast<int>(MemoryWatch::kInterval.count()));
    if (ready == 0 || (ready < 0 && errno == EINTR)) continue;
    const ssize_t count = read(file, buffer.data(), buffer.size());
    if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
    if (count == 0 || (count < 0 && errno != EINTR)) return text;
  }
}

/// The status of a process that has ended, or closed its output. One with a deadline is looked at every millisecond.
int wait_for(pid_t child, bool limited, Deadline& deadline, rusage& usage) {
  for (int status = 0;;) {
    const pid_t ended = wait4(child, &status, limited ? WNOHANG : 0, &usage);
    if (ended == child || (ended < 0 && errno != EINTR)) return status;
    deadline.look();
    if (ended == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

/// A child begins with the memory of the process that starts it, and the system counts that among its own. So a peak
/// that is no larger than this process's says nothing, and what was seen in between counts.
std::uint64_t peak_of_child(std::uint64_t counted, const MemoryWatch& watch) {
  return counted > peak_resident_bytes() || watch.peak() == 0 ? counted : watch.peak();
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

ChildResult run_child(const std::vector<std::string>& command, const ChildLimit& limit) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  const auto start = std::chrono::steady_clock::now();
  pid_t child = 0;
  const SpawnActions actions(ends[1]);
  const SpawnGroup group(limit.seconds > 0);
  const int error = posix_spawnp(&child, arguments[0], actions.get(), group.get(), arguments.data(), environ);
  close(ends[1]);
  if (error != 0) {
    close(ends[0]);
    throw std::system_error(error, std::generic_category(), "cannot start '" + command[0] + "'");
  }
  ChildResult result;
  MemoryWatch watch(child);
  Deadline deadline(child, limit);
  result.output = read_to_end(ends[0], watch, deadline);
  close(ends[0]);
  rusage usage{};
  const int status = wait_for(child, limit.seconds > 0, deadline, usage);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  result.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  result.cpu_seconds = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
  result.peak_bytes = peak_of_child(static_cast<std::uint64_t>(usage.ru_maxrss) * 1024, watch);
  result.swap_bytes = watch.swap();
  result.timed_out = deadline.passed();
  return result;
}

bool is_installed(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0) return true;
  }
  return false;
}

}  // namespace tetloom::bench
