#pragma once
// Where numbers of vertices and tets begin that belong to a whole of which no rank has all.
#include <atomic>
#include <cstdint>

namespace tetloom {

/// A mesh is the same whatever it is: tests let it be beyond 32 bits.
inline std::atomic<std::uint64_t>& first_number() {
  static std::atomic<std::uint64_t> first{0};
  return first;
}

}  // namespace tetloom
