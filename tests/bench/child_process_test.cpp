#include "bench/support/child_process.hpp"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "bench/support/machine.hpp"

using namespace tetloom::bench;

TEST_CASE("a child hands back its output, its exit status and its time") {
  const ChildResult child = run_child({"sh", "-c", "echo out; echo err >&2; sleep 0.2; exit 3"});
  CHECK(child.output == "out\nerr\n");
  CHECK(child.exit_status == 3);
  CHECK(child.seconds >= 0.2);
  CHECK(run_child({"sh", "-c", "kill -9 $$"}).exit_status == 128 + 9);
  CHECK_THROWS_AS(run_child({"/no/such/program"}), std::runtime_error);
}

TEST_CASE("a child whose time is up is asked to end, and killed where it does not") {
  const ChildResult asked =
      run_child({"sh", "-c", "trap 'echo asked; exit 5' INT; while :; do sleep 0.05; done"}, {0.2, 30});
  CHECK(asked.timed_out);
  CHECK(asked.exit_status == 5);
  CHECK(asked.output == "asked\n");
  const ChildResult killed = run_child({"sh", "-c", "trap '' INT; sleep 30"}, {0.2, 0.2});
  CHECK(killed.timed_out);
  CHECK(killed.exit_status == 128 + 9);
  CHECK_FALSE(run_child({"sh", "-c", "exit 0"}, {30, 1}).timed_out);
}

TEST_CASE("the peak memory of a child is its own, however large its parent has been") {
  // The kernel counts resident pages per core and adds them up late: tens of megabytes on machines with many cores.
  constexpr std::uint64_t kMegabyte = 1 << 20;
  { const std::vector<char> large(300 * kMegabyte, 1); }
  REQUIRE(peak_resident_bytes() > 200 * kMegabyte);
  const ChildResult small = run_child({"sleep", "0.2"});
  CHECK(small.peak_bytes > 0);
  CHECK(small.peak_bytes < 100 * kMegabyte);
  const ChildResult large = run_child({"dd", "if=/dev/zero", "of=/dev/null", "bs=500000000", "count=1", "status=none"});
  CHECK(large.output.empty());
  CHECK(large.peak_bytes > 350 * kMegabyte);
}

TEST_CASE("the memory of a process is read from its status") {
  const ProcessMemory own = read_process_memory("/proc/self/status");
  CHECK(own.resident > 0);
  CHECK(own.peak >= own.resident);
  const ProcessMemory none = read_process_memory("/no/such/file");
  CHECK((none.peak == 0 && none.resident == 0 && none.swapped == 0));
}
