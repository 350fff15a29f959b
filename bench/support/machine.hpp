#pragma once
// What a figure needs beside it to mean anything: the machine and how busy it is.
#include <cstdint>
#include <string>

namespace tetloom::bench {

struct Machine {
  std::string processor, system;
  int cores = 0;             ///< that this process may use
  std::uint64_t memory = 0;  ///< bytes
};

Machine describe_machine();

/// Today, as "2026-11-22", in universal time.
std::string today();

/// Processes that ran or waited for a core, on average over the last minute.
double load_average();

struct ProcessMemory {
  std::uint64_t peak = 0, resident = 0, swapped = 0;  ///< bytes; 0 where unknown
};

/// From a file like /proc/self/status.
ProcessMemory read_process_memory(const std::string& status_file);

/// The largest resident set of this process so far, and the present one; bytes.
std::uint64_t peak_resident_bytes();
std::uint64_t resident_bytes();

/// Touches so much memory and gives it back. The host of a virtual machine hands memory out at its first touch, and
/// takes back what lies idle for some seconds: a process that runs at once finds it there, as on a machine of metal.
void touch_memory(std::uint64_t bytes);

}  // namespace tetloom::bench
