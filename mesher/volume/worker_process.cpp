#include "mesher/volume/worker_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <sstream>
#include <utility>

#include "mesher/volume/worker_protocol.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

extern char** environ;

namespace tetloom::volume {

namespace {

constexpr const char* kWorkerName = "tetloom-tetgen";
constexpr int kPollMilliseconds = 50;    // bounds how late a cancellation is seen
constexpr int kGraceMilliseconds = 200;  // between the end of the conversation and that of the process

[[noreturn]] void fail(const std::string& message) { throw Error(ErrorCode::WorkerFailed, message); }

class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_ = -1;
};

bool is_executable(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored) && ::access(path.c_str(), X_OK) == 0;
}

std::vector<std::filesystem::path> candidate_workers() {
  std::vector<std::filesystem::path> candidates;
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    const auto folder = self.parent_path();
    for (const char* place : {".", "../libexec", "../libexec/tetloom", "../bin"}) {
      candidates.push_back((folder / place / kWorkerName).lexically_normal());
    }
  }
  if (const char* path = std::getenv("PATH")) {
    std::istringstream folders(path);
    for (std::string folder; std::getline(folders, folder, ':');) {
      if (!folder.empty()) candidates.push_back(std::filesystem::path(folder) / kWorkerName);
    }
  }
  return candidates;
}

std::string describe_end(int status) {
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    std::string text = "was ended by signal " + std::to_string(number);
    if (number == SIGKILL) text += " (killed from outside, or out of memory)";
    if (number == SIGABRT) text += " (an assertion of TetGen failed)";
    if (number == SIGSEGV) text += " (TetGen crashed)";
    return text;
  }
  return "ended with exit status " + std::to_string(WEXITSTATUS(status)) + " and without a result";
}

// Attributes and file actions of posix_spawn, released in any case.
class SpawnPlan {
 public:
  SpawnPlan(int channel, int error_output) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, channel, 0);
    posix_spawn_file_actions_adddup2(&actions_, channel, 1);
    posix_spawn_file_actions_adddup2(&actions_, error_output, 2);
    posix_spawn_file_actions_addclosefrom_np(&actions_, 3);
    posix_spawnattr_init(&attributes_);
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawnattr_setsigmask(&attributes_, &none);
    posix_spawnattr_setsigdefault(&attributes_, &all);
    posix_spawnattr_setpgroup(&attributes_, 0);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;
  ~SpawnPlan() {
    posix_spawnattr_destroy(&attributes_);
    posix_spawn_file_actions_destroy(&actions_);
  }
  const posix_spawn_file_actions_t* actions() const { return &actions_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

// A running worker; its destructor leaves no child behind.
class Child {
 public:
  explicit Child(const std::string& worker) {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) fail_with("no socket for", errno);
    channel_ = Descriptor(ends[0]);
    const Descriptor theirs(ends[1]);
    error_output_ = Descriptor(::memfd_create("tetloom-worker-errors", MFD_CLOEXEC));
    if (error_output_.get() < 0) fail_with("no buffer for the messages of", errno);
    const SpawnPlan plan(theirs.get(), error_output_.get());
    std::array<char*, 2> arguments{const_cast<char*>(worker.c_str()), nullptr};
    const int error =
        ::posix_spawn(&pid_, worker.c_str(), plan.actions(), plan.attributes(), arguments.data(), environ);
    if (error != 0) {
      pid_ = -1;
      fail_with("cannot start", error);
    }
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      reap();
    }
  }

  int channel() const { return channel_.get(); }

  // Waits for the end of a child that has closed its side of the channel; says how it ended and what it wrote last.
  WorkerRun end() {
    if (pid_ > 0 && !ends_within(kGraceMilliseconds)) ::kill(pid_, SIGKILL);
    const std::optional<int> status = reap();
    WorkerRun run;
    run.failure = "the volume worker " + (status ? describe_end(*status) : "ended without a result");
    if (const std::string errors = last_errors(); !errors.empty()) run.failure += "; it said: " + errors;
    run.crashed = status && WIFSIGNALED(*status) && WTERMSIG(*status) != SIGKILL && WTERMSIG(*status) != SIGTERM;
    return run;
  }

 private:
  [[noreturn]] static void fail_with(const char* what, int error) {
    fail(std::string(what) + " the volume worker: " + std::strerror(error));
  }

  bool ends_within(int milliseconds) const {
    for (int waited = 0; waited < milliseconds; ++waited) {
      siginfo_t info{};
      if (::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid != 0)
        return true;
      ::poll(nullptr, 0, 1);
    }
    return false;
  }

  // Nothing when somebody else, such as a host that ignores SIGCHLD, has taken the child's status.
  std::optional<int> reap() {
    int status = 0;
    pid_t result = -1;
    do {
      result = ::waitpid(pid_, &status, 0);
    } while (result < 0 && errno == EINTR);
    pid_ = -1;
    return result > 0 ? std::optional(status) : std::nullopt;
  }

  std::string last_errors() const {
    std::array<char, 400> text{};
    const off_t size = ::lseek(error_output_.get(), 0, SEEK_END);
    const off_t from = std::max<off_t>(0, size - static_cast<off_t>(text.size()));
    const ssize_t got = ::pread(error_output_.get(), text.data(), text.size(), from);
    std::string result(text.data(), got > 0 ? static_cast<std::size_t>(got) : 0);
    for (char& c : result) {
      if (static_cast<unsigned char>(c) < ' ') c = ' ';
    }
    const auto last = result.find_last_not_of(' ');
    return last == std::string::npos ? "" : result.substr(0, last + 1);
  }

  Descriptor channel_, error_output_;
  pid_t pid_ = -1;
};

// Sends the request and collects the response at the same time, so that neither side can wait for the other for ever.
class Conversation {
 public:
  Conversation(int channel, std::span<const std::byte> request) : channel_(channel), unsent_(request) {}

  // One wait of at most kPollMilliseconds, and what can be moved then; false once nothing more will come.
  bool step() {
    pollfd entry{channel_, static_cast<short>(POLLIN | (unsent_.empty() ? 0 : POLLOUT)), 0};
    if (::poll(&entry, 1, kPollMilliseconds) < 0) return errno == EINTR;
    if ((entry.revents & POLLOUT) != 0) send_some();
    if ((entry.revents & (POLLIN | POLLHUP | POLLERR)) != 0) return receive_some();
    return true;
  }
  bool complete() {
    if (!header_) header_ = decode_header(received_, FrameKind::Response);
    return header_ && received_.size() >= sizeof(FrameHeader) + header_->payload_size;
  }
  std::vector<std::byte> take() { return std::move(received_); }

 private:
  void send_some() {
    const ssize_t sent = ::send(channel_, unsent_.data(), unsent_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) unsent_ = unsent_.subspan(static_cast<std::size_t>(sent));
    // A child that reads no more may still have answered; what it sent decides.
    if (sent < 0 && errno != EAGAIN && errno != EINTR) unsent_ = {};
  }
  bool receive_some() {
    std::array<std::byte, 1 << 16> block;
    for (;;) {
      const ssize_t got = ::recv(channel_, block.data(), block.size(), MSG_DONTWAIT);
      if (got < 0) return errno == EAGAIN || errno == EINTR;
      if (got == 0) return false;
      received_.insert(received_.end(), block.begin(), block.begin() + got);
      if (static_cast<std::size_t>(got) < block.size()) return true;
    }
  }

  int channel_;
  std::span<const std::byte> unsent_;
  std::vector<std::byte> received_;
  std::optional<FrameHeader> header_;
};

}  // namespace

std::string find_worker(const std::string& wanted) {
  if (!wanted.empty()) {
    if (is_executable(wanted)) return wanted;
    fail("the volume worker '" + wanted + "' is not a file that can be executed");
  }
  for (const auto& candidate : candidate_workers()) {
    if (is_executable(candidate)) return candidate.string();
  }
  fail(std::string("the volume worker '") + kWorkerName +
       "' was not found beside the executable, in its libexec folder or in PATH: build tetloom with TETLOOM_TETGEN=ON "
       "(needs libtet1.5-dev) and install it, or name its path");
}

WorkerRun run_worker(const std::string& worker, std::span<const std::byte> request, const TaskRunner& runner) {
  runner.check_cancelled();
  Child child(worker);
  Conversation conversation(child.channel(), request);
  while (!conversation.complete()) {
    runner.check_cancelled();
    if (!conversation.step() && !conversation.complete()) return child.end();
  }
  return {conversation.take(), {}, false};
}

}  // namespace tetloom::volume
