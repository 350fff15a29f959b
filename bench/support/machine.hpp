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

/// Processes that ran or waited for a core, on average over the last minute.
double load_average();

/// The largest resident set of this process so far, and the present one; bytes.
std::uint64_t peak_resident_bytes();
std::uint64_t resident_bytes();

}  // namespace tetloom::bench
