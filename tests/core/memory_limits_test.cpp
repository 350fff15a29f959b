// How much memory a process can get, from files like those of Linux.
#include "core/sizing/memory_limits.hpp"

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "tests/support/sanitized.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace tetloom;

namespace {

constexpr std::uint64_t kMegabyte = std::uint64_t{1} << 20;

/// A root with files of that kind.
class FakeRoot {
 public:
  void write(const std::string& path, const std::string& text) const {
    const std::filesystem::path file = folder_.path() / path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  void write_bytes(const std::string& path, std::uint64_t megabytes) const {
    write(path, std::to_string(megabytes * kMegabyte) + "\n");
  }
  std::uint64_t machine() const { return memory_limits(folder_.path()).machine; }

 private:
  test::TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("memory is what the machine has free, where nothing else is known") {
  const FakeRoot root;
  CHECK(root.machine() == MemoryLimits::kUnlimited);
  root.write("proc/meminfo", "MemTotal: 9000000 kB\nMemFree: 12 kB\nMemAvailable:  2048 kB\n");
  CHECK(root.machine() == 2 * kMegabyte);
  CHECK(memory_limits().machine > kMegabyte);
}

TEST_CASE("memory ends at the limits of the control group and of those above it") {
  const FakeRoot root;
  root.write("proc/meminfo", "MemAvailable: 1024000000 kB\n");
  SECTION("of the second version") {
    root.write("proc/self/cgroup", "0::/jobs/one\n");
    root.write("sys/fs/cgroup/jobs/one/memory.max", "max\n");
    root.write_bytes("sys/fs/cgroup/jobs/one/memory.current", 300);
    CHECK(root.machine() > 900'000 * kMegabyte);
    root.write_bytes("sys/fs/cgroup/jobs/memory.max", 700);
    root.write_bytes("sys/fs/cgroup/jobs/memory.current", 400);
    CHECK(root.machine() == 300 * kMegabyte);
    root.write("sys/fs/cgroup/jobs/memory.stat", "anon 5\ninactive_file " + std::to_string(60 * kMegabyte) +
                                                     "\nactive_file " + std::to_string(40 * kMegabyte) + "\n");
    CHECK(root.machine() == 400 * kMegabyte);
    root.write_bytes("sys/fs/cgroup/jobs/one/memory.max", 310);
    CHECK(root.machine() == 10 * kMegabyte);
    root.write_bytes("sys/fs/cgroup/jobs/one/memory.current", 500);
    CHECK(root.machine() == 0);
  }
  SECTION("of the first version") {
    root.write("proc/self/cgroup", "4:cpu,cpuacct:/x\n3:memory:/box\n2:pids:/\n");
    root.write_bytes("sys/fs/cgroup/memory/memory.limit_in_bytes", 900);
    root.write_bytes("sys/fs/cgroup/memory/memory.usage_in_bytes", 100);
    CHECK(root.machine() == 800 * kMegabyte);
    root.write_bytes("sys/fs/cgroup/memory/box/memory.limit_in_bytes", 200);
    root.write_bytes("sys/fs/cgroup/memory/box/memory.usage_in_bytes", 50);
    CHECK(root.machine() == 150 * kMegabyte);
  }
  SECTION("whose files make no sense") {
    root.write("proc/self/cgroup", "rubbish\n0::\n:::\n");
    root.write("sys/fs/cgroup/memory.max", "many\n");
    CHECK(root.machine() > 900'000 * kMegabyte);
  }
}

TEST_CASE("processes that ask for the same share what is free, but not what each is allowed") {
  MemoryLimits limits;
  CHECK(limits.for_each_of(8) == MemoryLimits::kUnlimited);
  limits.machine = 800;
  CHECK(limits.for_each_of(1) == 800);
  CHECK(limits.for_each_of(8) == 100);
  limits.process = 150;
  CHECK(limits.for_each_of(1) == 150);
  CHECK(limits.for_each_of(8) == 100);
}

TEST_CASE("a process that may only have so much data has no more memory than that") {
  if (test::kSanitized) return;  // which maps more than any limit allows
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_DATA, &before) == 0);
  rlimit limit = before;
  limit.rlim_cur = std::uint64_t{1} << 40;
  REQUIRE(::setrlimit(RLIMIT_DATA, &limit) == 0);
  const std::uint64_t room = memory_limits().process;
  REQUIRE(::setrlimit(RLIMIT_DATA, &before) == 0);
  CHECK(room < std::uint64_t{1} << 40);
  CHECK(room > std::uint64_t{1} << 36);
}
