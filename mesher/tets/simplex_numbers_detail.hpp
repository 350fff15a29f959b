#pragma once
// Numbers of the pairs, triples and quadruples of small ids, whatever their order.
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace tetloom::tets {

inline constexpr std::uint32_t pairs(std::uint32_t n) { return n * (n - 1) / 2; }
inline constexpr std::uint32_t triples(std::uint32_t n) { return n * (n - 1) * (n - 2) / 6; }
inline constexpr std::uint32_t quads(std::uint32_t n) { return n * (n - 1) * (n - 2) / 6 * (n - 3) / 4; }

/// Sorts; 1 after an even permutation, -1 after an odd one.
inline int sort_with_parity(std::array<std::uint32_t, 4>& v) {
  int parity = 1;
  const auto order = [&](int i, int j) {
    if (v[i] > v[j]) std::swap(v[i], v[j]), parity = -parity;
  };
  order(0, 1), order(2, 3), order(0, 2), order(1, 3), order(1, 2);
  return parity;
}

inline std::uint32_t pair_number(std::uint32_t a, std::uint32_t b) { return a < b ? pairs(b) + a : pairs(a) + b; }
inline std::uint32_t triple_number(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (a > b) std::swap(a, b);
  if (b > c) std::swap(b, c);
  if (a > b) std::swap(a, b);
  return triples(c) + pairs(b) + a;
}
/// Pre: ascending.
inline std::uint32_t quad_number(const std::array<std::uint32_t, 4>& v) {
  return quads(v[3]) + triples(v[2]) + pairs(v[1]) + v[0];
}
inline bool is_even(std::uint32_t a, std::uint32_t b, std::uint32_t c) { return (a < b) == ((b < c) == (a < c)); }

/// The faces of a tet of positive volume, counter-clockwise as seen from inside; number 0 is the one it starts with.
inline std::array<std::uint8_t, 3> inner_face(const std::array<std::uint8_t, 4>& t, int i) {
  switch (i) {
    case 0: return {t[0], t[1], t[2]};
    case 1: return {t[0], t[3], t[1]};
    case 2: return {t[0], t[2], t[3]};
    default: return {t[1], t[3], t[2]};
  }
}

}  // namespace tetloom::tets
