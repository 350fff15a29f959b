#pragma once
// Numbers as text, for the lines of files that are written in parallel.
#include <charconv>
#include <cstddef>
#include <type_traits>

namespace tetloom::detail {

inline constexpr std::size_t kRealBytes = 25, kIntegerBytes = 11;  // at most, with the character behind; 32-bit indices

inline constexpr std::size_t kMostNumber = 0x7fffffff;  ///< of what is numbered in 32 bits with a sign

/// A number in the shortest form that reads back as the same one, and a character behind it.
template <class Number>
char* print(char* out, Number number, char behind) {
  constexpr std::size_t most = std::is_floating_point_v<Number> ? kRealBytes : kIntegerBytes;
  out = std::to_chars(out, out + most - 1, number).ptr;
  *out = behind;
  return out + 1;
}

}  // namespace tetloom::detail
