// The tetloom command: reads its arguments, runs the subcommand, turns the outcome into an exit status.
#include <malloc.h>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>

#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/console.hpp"
#include "apps/tetloom/model_reading.hpp"
#include "apps/tetloom/options.hpp"
#include "apps/tetloom/ranks.hpp"
#include "apps/tetloom/report.hpp"

namespace tetloom::app {
namespace {

/// A wrong command line is reported like any other failure, where it says to which file.
void report_usage_error(const std::string& message, int argc, const char* const* argv) {
  const std::optional<std::filesystem::path> path = find_report_argument(argc, argv);
  if (!path) return;
  RunReport report;
  add_failure(report, {ErrorCode::InvalidArgument, message, {}, {}, {}});
  try {
    write_report(report, *path);
  } catch (const Error& error) {
    print(stderr, render_diagnostic("tetloom: error", error.diagnostic()));
  }
}

struct Dispatch {
  int& argc;
  char**& argv;

  ExitStatus operator()(const MeshCommand& command) const {
    ModelReading reading(command);
    return run_mesh(command, reading, Ranks(argc, argv).communicator());
  }
  ExitStatus operator()(const InfoCommand& command) const {
    return run_info(command, Ranks(argc, argv).communicator());
  }
  ExitStatus operator()(const CheckCommand& command) const {
    return run_check(command, Ranks(argc, argv).communicator());
  }
  ExitStatus operator()(const PartitionCommand& command) const {
    return run_partition(command, Ranks(argc, argv).communicator());
  }
  ExitStatus operator()(const AdaptCommand& command) const {
    return run_adapt(command, Ranks(argc, argv).communicator());
  }
  ExitStatus operator()(const Printout& printout) const {
    if (is_first_process()) print(stdout, printout.text);
    return ExitStatus::Done;
  }
};

ExitStatus run(int& argc, char**& argv) {
  try {
    return std::visit(Dispatch{argc, argv}, parse_command_line(argc, argv));
  } catch (const UsageError& error) {
    if (!is_first_process()) return ExitStatus::WrongUsage;
    print(stderr, std::string("tetloom: ") + error.what() + "\nTry 'tetloom --help' or 'tetloom mesh --help'.\n");
    report_usage_error(error.what(), argc, argv);
    return ExitStatus::WrongUsage;
  }
}

/// Memory that is kept for the way out: an allocation that fails gives it back first, so that what is small and cannot
/// fail gracefully (a task of oneTBB, the text of an error, the report) still finds some.
class MemoryReserve {
 public:
  MemoryReserve() {
    block_ = std::malloc(kBytes);
    std::set_new_handler(&MemoryReserve::spend);
  }

 private:
  static constexpr std::size_t kBytes = std::size_t{2} << 20;

  static void spend() {
    std::free(block_.exchange(nullptr));
    throw std::bad_alloc();
  }

  static inline std::atomic<void*> block_{nullptr};  // whoever takes the pointer out frees it
};

/// The stages of a run ask for the same memory one after the other. By default glibc gives what is large or free at the
/// end back to the system at once, and the page faults of taking it again are a twentieth of a run. Here blocks up to
/// 64 MB come from the heap, and up to 256 MB stay free at its end.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 64 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
  mallopt(M_TOP_PAD, 16 << 20);
#endif
}

}  // namespace
}  // namespace tetloom::app

int main(int argc, char** argv) {
  // A reader that goes away and a limit on the size of files show up as errors of write(2), which are handled.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  const tetloom::app::MemoryReserve reserve;  // outside of the heap: what is given back serves all threads
  tetloom::app::keep_freed_memory();
  return static_cast<int>(tetloom::app::run(argc, argv));
}
