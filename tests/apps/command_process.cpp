#include "tests/apps/command_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

namespace tetloom::test {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

[[noreturn]] void become(const std::vector<std::string>& argv, const ProcessOptions& options) {
  std::vector<char*> pointers;
  for (const std::string& argument : argv) pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  if (options.in_child) options.in_child();
  ::execv(pointers[0], pointers.data());
  ::_exit(127);
}

/// The pipes to a child, read until it has closed both.
class Listener {
 public:
  explicit Listener(const ProcessOptions& options) : options_(options) {}

  void open() {
    REQUIRE(::pipe2(out_.data(), O_CLOEXEC) == 0);
    REQUIRE(::pipe2(err_.data(), O_CLOEXEC) == 0);
  }
  void connect_child() {
    ::dup2(out_[1], 1);
    ::dup2(err_[1], 2);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, 0);
    if (options_.close_stdout) ::close(out_[0]);
  }
  ProcessResult listen(pid_t child) {
    ::close(out_[1]);
    ::close(err_[1]);
    if (options_.close_stdout) {
      ::close(out_[0]);
      out_[0] = -1;
    }
    const auto start = Clock::now();
    while (out_[0] >= 0 || err_[0] >= 0) {
      if (seconds_since(start) > options_.limit_seconds) ::kill(child, SIGKILL);
      wait_for_text();
      send_signals(child);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (signalled_) result_.seconds_after_signal = seconds_since(signal_time_);
    result_.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return result_;
  }

 private:
  void wait_for_text() {
    std::array<pollfd, 2> files{{{out_[0], POLLIN, 0}, {err_[0], POLLIN, 0}}};
    ::poll(files.data(), files.size(), 100);
    take(out_[0], files[0].revents, result_.out);
    take(err_[0], files[1].revents, result_.err);
  }
  static void take(int& descriptor, short events, std::string& text) {
    if (descriptor < 0 || events == 0) return;
    std::array<char, 4096> buffer{};
    const ssize_t length = ::read(descriptor, buffer.data(), buffer.size());
    if (length > 0) {
      text.append(buffer.data(), static_cast<std::size_t>(length));
    } else {
      ::close(descriptor);
      descriptor = -1;
    }
  }
  void send_signals(pid_t child) {
    if (signalled_ || !options_.signal_when || result_.err.find(*options_.signal_when) == std::string::npos) return;
    signalled_ = true;
    signal_time_ = Clock::now();
    for (const int signal : options_.signals) {
      ::kill(child, signal);
      ::usleep(20'000);  // two signals of a kind at once would become one
    }
  }

  const ProcessOptions& options_;
  ProcessResult result_;
  std::array<int, 2> out_{}, err_{};
  bool signalled_ = false;
  Clock::time_point signal_time_;
};

}  // namespace

ProcessResult run_process(const std::vector<std::string>& argv, const ProcessOptions& options) {
  Listener listener(options);
  listener.open();
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    listener.connect_child();
    become(argv, options);
  }
  return listener.listen(child);
}

ProcessResult run_tetloom(std::vector<std::string> arguments, const ProcessOptions& options) {
  arguments.insert(arguments.begin(), TETLOOM_EXECUTABLE);
  return run_process(arguments, options);
}

std::vector<std::string> TestFolder::files() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

nlohmann::json read_json(const std::string& path) { return nlohmann::json::parse(read_text(path)); }

std::string demo_model(const std::string& kind) {
  static const TestFolder folder;
  static std::map<std::string, std::string> made;
  if (const auto found = made.find(kind); found != made.end()) return found->second;
  const std::string path = folder / (kind + ".step");
  const ProcessResult result = run_process({TETLOOM_DEMO_MODEL, kind, path});
  INFO(result.err);
  REQUIRE(result.status == 0);
  return made[kind] = path;
}

std::string cube_stl(int facets) {
  static constexpr std::array<std::array<int, 3>, 8> corners{
      {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
  static constexpr std::array<std::array<std::size_t, 3>, 12> triangles{{{0, 2, 1},
                                                                         {0, 3, 2},
                                                                         {4, 5, 6},
                                                                         {4, 6, 7},
                                                                         {0, 1, 5},
                                                                         {0, 5, 4},
                                                                         {1, 2, 6},
                                                                         {1, 6, 5},
                                                                         {2, 3, 7},
                                                                         {2, 7, 6},
                                                                         {3, 0, 4},
                                                                         {3, 4, 7}}};
  std::string text = "solid cube\n";
  for (int t = 0; t < facets; ++t) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const std::size_t c : triangles[static_cast<std::size_t>(t)]) {
      text += "vertex " + std::to_string(corners[c][0]) + " " + std::to_string(corners[c][1]) + " " +
              std::to_string(corners[c][2]) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid cube\n";
}

void check_cancelled(const ProcessResult& result, const TestFolder& folder, const std::vector<std::string>& files) {
  CAPTURE(result.err);
  CHECK(result.status == 5);
  CHECK(folder.files() == files);
  const nlohmann::json report = read_json(folder / "r.json");
  CHECK(report["status"] == "cancelled");
  CHECK(report["errors"][0]["code"] == "cancelled");
  CHECK(report["seconds"]["read"] > 0);
}

bool is_sanitized() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return true;
#else
  return false;
#endif
}

}  // namespace tetloom::test
