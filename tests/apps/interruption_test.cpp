// What happens after Ctrl-C when the library does not come back.
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>

#include "apps/tetloom/interruption.hpp"
#include "apps/tetloom/run.hpp"
#include "core/io/atomic_file.hpp"
#include "tests/apps/command_process.hpp"

using namespace tetloom;
using namespace tetloom::app;
using tetloom::test::in_time;
using tetloom::test::TestFolder;

namespace {

struct ChildEnd {
  int status = 0;
  double seconds = 0;
};

/// Runs `body` in a child process.
template <class Body>
ChildEnd run_child(const Body& body) {
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    body();
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1,
          std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count()};
}

}  // namespace

TEST_CASE("a run that ignores the signal is left within a second, without its temporaries") {
  CHECK(in_time([] {
    const TestFolder folder;
    const std::string target = folder / "out.vtu";
    const ChildEnd end = run_child([&] {
      const Interruption interruption([&] { remove_temporaries_of(target); });
      AtomicFile file(target);
      file.write("half");
      std::raise(SIGINT);
      ::sleep(20);
    });
    CHECK(end.status == 5);
    CHECK(end.seconds > 0.8);
    CHECK(folder.files().empty());
    return end.seconds < 1.5;
  }));
}

TEST_CASE("a run that is stuck leaves a report with the seconds of its stages so far") {
  const TestFolder folder;
  const ChildEnd end = run_child([&] {
    RunSetup setup;
    setup.input = "part.step", setup.report = folder / "r.json", setup.quiet = true;
    Run run(setup);
    run.execute([](Run& r) {
      r.begin(Stage::Read);
      ::usleep(20'000);
      r.host().progress({Stage::SizeField, {}, 0, 0});
      ::usleep(20'000);
      r.host().progress({Stage::Faces, {}, 0, 7});
      std::raise(SIGTERM);
      ::sleep(20);
    });
  });
  CHECK(end.status == 5);
  const nlohmann::json report = test::read_json(folder / "r.json");
  CHECK(report["status"] == "cancelled");
  CHECK(report["seconds"]["read"] >= 0.02);
  CHECK(report["seconds"]["size_field"] >= 0.02);
  CHECK(report["seconds"]["surface"] > 0.8);
  CHECK(report["seconds"]["volume"] == 0);
}

TEST_CASE("a second signal leaves at once") {
  CHECK(in_time([] {
    const ChildEnd end = run_child([] {
      const Interruption interruption([] {});
      std::raise(SIGINT);
      std::raise(SIGTERM);
      ::sleep(20);
    });
    CHECK(end.status == 5);
    return end.seconds < 0.7;
  }));
}

TEST_CASE("a signal raises the token, and a run that listens to it ends by itself") {
  CHECK(in_time([] {
    const ChildEnd end = run_child([] {
      const Interruption interruption([] { ::_exit(9); });
      if (interruption.token().cancelled()) ::_exit(1);
      std::raise(SIGTERM);
      for (int i = 0; i < 1000 && !interruption.token().cancelled(); ++i) ::usleep(1000);
      if (!interruption.token().cancelled()) ::_exit(2);
    });
    CHECK(end.status == 0);
    return end.seconds < 0.8;
  }));
}

TEST_CASE("temporaries of other files and of other processes are left alone") {
  const TestFolder folder;
  folder.write(".out.vtu." + std::to_string(::getpid()) + "-0.tmp", "mine");
  folder.write(".out.vtu." + std::to_string(::getpid() + 1) + "-0.tmp", "another process");
  folder.write(".other.vtu." + std::to_string(::getpid()) + "-0.tmp", "another file");
  folder.write("out.vtu", "the old one");
  remove_temporaries_of(folder / "out.vtu");
  CHECK(folder.files().size() == 3);
  CHECK(test::read_text(folder / "out.vtu") == "the old one");
  CHECK_NOTHROW(remove_temporaries_of(folder / "no such folder/out.vtu"));
}
