#pragma once
// How much memory a process can still get, whoever sets the limit (Linux).
#include <cstdint>
#include <filesystem>
#include <limits>

namespace tetloom {

/// Bytes; kUnlimited where nothing is known.
struct MemoryLimits {
  static constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t process = kUnlimited;  ///< of this process alone, by its resource limits (ulimit -d and -v)
  std::uint64_t machine =
      kUnlimited;  ///< of all processes of the machine or control group together: what is free there

  /// Of each of so many processes that ask for the same. Pre: processes >= 1.
  std::uint64_t for_each_of(int processes) const;
};

/// As they are now. `root`: where /proc and /sys/fs/cgroup lie; control groups of both versions are known. What page
/// caches could give back counts as free.
MemoryLimits memory_limits(const std::filesystem::path& root = "/");

}  // namespace tetloom
