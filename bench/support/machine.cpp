#include "bench/support/machine.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <utility>

namespace tetloom::bench {
namespace {

/// What follows "key" and a colon in a file of such lines; empty when it is not there.
std::string value_of(const char* file, const std::string& key) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(':');
    if (!line.starts_with(key) || colon == std::string::npos) continue;
    const std::size_t begin = line.find_first_not_of(" \t", colon + 1);
    return begin == std::string::npos ? "" : line.substr(begin);
  }
  return "";
}

constexpr const char* kOwnStatus = "/proc/self/status";

}  // namespace

Machine describe_machine() {
  Machine machine;
  machine.processor = value_of("/proc/cpuinfo", "model name");
  utsname names{};
  if (uname(&names) == 0) machine.system = std::string(names.sysname) + " " + names.release + " " + names.machine;
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  machine.cores = sched_getaffinity(0, sizeof(allowed), &allowed) == 0 ? CPU_COUNT(&allowed) : 1;
  machine.memory =
      static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  return machine;
}

double load_average() {
  double load = 0;
  return getloadavg(&load, 1) == 1 ? load : 0;
}

std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%d", &parts);
  return text;
}

ProcessMemory read_process_memory(const std::string& status_file) {
  ProcessMemory memory;
  std::ifstream lines(status_file);
  for (std::string line; std::getline(lines, line);)
    for (const auto& [key, value] : {std::pair("VmHWM:", &memory.peak), std::pair("VmRSS:", &memory.resident),
                                     std::pair("VmSwap:", &memory.swapped)})
      if (line.starts_with(key)) *value = 1024 * std::strtoull(line.c_str() + std::strlen(key), nullptr, 10);
  return memory;
}

std::uint64_t peak_resident_bytes() { return read_process_memory(kOwnStatus).peak; }
std::uint64_t resident_bytes() { return read_process_memory(kOwnStatus).resident; }

void touch_memory(std::uint64_t bytes) {
  constexpr std::size_t kPage = 1 << 12;
  void* const storage =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (storage == MAP_FAILED) return;
  ::madvise(storage, bytes, MADV_HUGEPAGE);
  for (std::size_t at = 0; at < bytes; at += kPage) static_cast<volatile char*>(storage)[at] = 0;
  ::munmap(storage, bytes);
}

}  // namespace tetloom::bench
