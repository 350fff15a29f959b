#pragma once
// Bits mixed so that numbers that follow each other look like random ones: the finaliser of SplitMix64 (Steele, Lea,
// Flood 2014), whose constants are Stafford's.
#include <cstdint>

namespace tetloom {

/// The last two of the three steps, for what is a product by an odd constant already.
constexpr std::uint64_t finish_mixing(std::uint64_t x) {
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

/// One to one; 0 stays 0.
constexpr std::uint64_t mix_bits(std::uint64_t x) { return finish_mixing((x ^ x >> 30) * 0xbf58476d1ce4e5b9u); }

}  // namespace tetloom
