// The tetloom command: reads its arguments, runs the subcommand, turns the outcome into an exit status.
#include <csignal>
#include <cstdio>
#include <string>

#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/console.hpp"
#include "apps/tetloom/options.hpp"
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
  ExitStatus operator()(const MeshCommand& command) const { return run_mesh(command); }
  ExitStatus operator()(const InfoCommand& command) const { return run_info(command); }
  ExitStatus operator()(const CheckCommand& command) const { return run_check(command); }
  ExitStatus operator()(const Printout& printout) const {
    print(stdout, printout.text);
    return ExitStatus::Done;
  }
};

ExitStatus run(int argc, const char* const* argv) {
  try {
    return std::visit(Dispatch{}, parse_command_line(argc, argv));
  } catch (const UsageError& error) {
    print(stderr, std::string("tetloom: ") + error.what() + "\nTry 'tetloom --help' or 'tetloom mesh --help'.\n");
    report_usage_error(error.what(), argc, argv);
    return ExitStatus::WrongUsage;
  }
}

}  // namespace
}  // namespace tetloom::app

int main(int argc, char** argv) {
  // A reader that goes away and a limit on the size of files show up as errors of write(2), which are handled.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  return static_cast<int>(tetloom::app::run(argc, argv));
}
