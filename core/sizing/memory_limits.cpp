#include "core/sizing/memory_limits.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>

namespace tetloom {

namespace {

constexpr std::uint64_t kUnlimited = MemoryLimits::kUnlimited;

std::uint64_t difference(std::uint64_t a, std::uint64_t b) { return a > b ? a - b : 0; }

// The number that a file holds; nothing where it holds none, as "max".
std::optional<std::uint64_t> number_in(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::uint64_t value = 0;
  return file >> value ? std::optional(value) : std::nullopt;
}

// The number behind a word at the beginning of a line.
std::optional<std::uint64_t> number_behind(const std::filesystem::path& path, const std::string& word) {
  std::ifstream file(path);
  std::string line, key;
  while (std::getline(file, line)) {
    std::istringstream text(line);
    std::uint64_t value = 0;
    if (text >> key >> value && key == word) return value;
  }
  return std::nullopt;
}

struct GroupFiles {
  const char *folder, *limit, *usage;
  std::array<const char*, 2> reclaimable;  // of memory.stat: files that the kernel keeps as long as nobody wants more
};
constexpr GroupFiles kSecondVersion{"sys/fs/cgroup", "memory.max", "memory.current", {"inactive_file", "active_file"}};
constexpr GroupFiles kFirstVersion{"sys/fs/cgroup/memory",
                                   "memory.limit_in_bytes",
                                   "memory.usage_in_bytes",
                                   {"total_inactive_file", "total_active_file"}};

std::uint64_t room_of_group(const std::filesystem::path& folder, const GroupFiles& files) {
  const auto limit = number_in(folder / files.limit), usage = number_in(folder / files.usage);
  if (!limit || !usage) return kUnlimited;
  std::uint64_t cached = 0;
  for (const char* word : files.reclaimable) cached += number_behind(folder / "memory.stat", word).value_or(0);
  return difference(*limit, difference(*usage, cached));
}

// Of a group and all above it. Inside of a container the path may be one that is known outside alone.
std::uint64_t room_of_groups(const std::filesystem::path& base, const std::filesystem::path& group,
                             const GroupFiles& files) {
  std::uint64_t room = room_of_group(base, files);
  std::filesystem::path folder = base;
  for (const std::filesystem::path& step : group.relative_path()) {
    folder /= step;
    room = std::min(room, room_of_group(folder, files));
  }
  return room;
}

// Lines are number:controllers:path; the second version has no controllers.
std::uint64_t room_of_control_groups(const std::filesystem::path& root) {
  std::ifstream file(root / "proc/self/cgroup");
  std::uint64_t room = kUnlimited;
  std::string line;
  while (std::getline(file, line)) {
    const std::size_t first = line.find(':'), second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",",
                      path = line.substr(second + 1);
    if (controllers == ",,") room = std::min(room, room_of_groups(root / kSecondVersion.folder, path, kSecondVersion));
    if (controllers.find(",memory,") != std::string::npos)
      room = std::min(room, room_of_groups(root / kFirstVersion.folder, path, kFirstVersion));
  }
  return room;
}

std::uint64_t room_of_process(const std::filesystem::path& root) {
  std::ifstream file(root / "proc/self/statm");  // pages: size, resident, shared, text, lib, data
  std::array<std::uint64_t, 6> pages{};
  for (std::uint64_t& count : pages) file >> count;
  const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  const auto room = [&](auto resource, std::uint64_t used) {
    rlimit limit{};
    if (::getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnlimited;
    return difference(limit.rlim_cur, used * page);
  };
  return std::min(room(RLIMIT_DATA, pages[5]), room(RLIMIT_AS, pages[0]));
}

}  // namespace

std::uint64_t MemoryLimits::for_each_of(int processes) const {
  const bool known = machine != kUnlimited;
  return std::min(process, known ? machine / static_cast<std::uint64_t>(processes) : kUnlimited);
}

MemoryLimits memory_limits(const std::filesystem::path& root) {
  MemoryLimits limits;
  if (const auto kilobytes = number_behind(root / "proc/meminfo", "MemAvailable:")) limits.machine = 1024 * *kilobytes;
  limits.machine = std::min(limits.machine, room_of_control_groups(root));
  limits.process = room_of_process(root);
  return limits;
}

}  // namespace tetloom
