#pragma once
// Morton codes: the bits of three coordinates interleaved, so that sorting by code walks an octree depth first.
#include <algorithm>
#include <array>
#include <cstdint>

#include "tetloom/vec.hpp"

namespace tetloom {

/// Spreads the low 21 bits of `x` to every third bit.
constexpr std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x001f00000000ffffULL;
  x = (x | x << 16) & 0x001f0000ff0000ffULL;
  x = (x | x << 8) & 0x100f00f00f00f00fULL;
  x = (x | x << 4) & 0x10c30c30c30c30c3ULL;
  return (x | x << 2) & 0x1249249249249249ULL;
}

/// The inverse of spread_bits.
constexpr std::uint32_t gather_bits(std::uint64_t x) {
  x &= 0x1249249249249249ULL;
  x = (x | x >> 2) & 0x10c30c30c30c30c3ULL;
  x = (x | x >> 4) & 0x100f00f00f00f00fULL;
  x = (x | x >> 8) & 0x001f0000ff0000ffULL;
  x = (x | x >> 16) & 0x001f00000000ffffULL;
  return static_cast<std::uint32_t>((x | x >> 32) & 0x1fffff);
}

/// Pre: coordinates below 2^21. Bit 0 of each octal digit is x, bit 1 is y, bit 2 is z.
constexpr std::uint64_t morton_encode(const std::array<std::uint32_t, 3>& c) {
  return spread_bits(c[0]) | spread_bits(c[1]) << 1 | spread_bits(c[2]) << 2;
}

/// The largest coordinate.
inline constexpr double kMostMorton = 2097151;

/// Of the cell of `point` in a grid with `scale` cells per unit of length from `origin` on; the nearest one outside.
inline std::uint64_t morton_of(const Vec3& point, const Vec3& origin, double scale) {
  const auto cell = [&](double x, double lo) {
    return static_cast<std::uint32_t>(std::clamp((x - lo) * scale, 0.0, kMostMorton));
  };
  return morton_encode({cell(point.x, origin.x), cell(point.y, origin.y), cell(point.z, origin.z)});
}

constexpr std::array<std::uint32_t, 3> morton_decode(std::uint64_t code) {
  return {gather_bits(code), gather_bits(code >> 1), gather_bits(code >> 2)};
}

}  // namespace tetloom
