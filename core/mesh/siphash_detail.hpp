#pragma once
// Private to core/mesh: SipHash-2-4 with 128-bit output (J.-P. Aumasson & D. J. Bernstein, "SipHash: a fast short-input
// PRF", 2012, and their reference code for the 128-bit variant), restricted to messages of whole 64-bit words.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tetloom::detail {

/// 128 bits, which are added so that order does not count.
struct Hash128 {
  std::uint64_t low = 0, high = 0;
  /// Addition modulo 2^128.
  Hash128& operator+=(const Hash128& b) {
    low += b.low;
    high += b.high + (low < b.low ? 1u : 0u);
    return *this;
  }
};

/// The state of SipHash with two keys.
class SipState {
 public:
  SipState(std::uint64_t key0, std::uint64_t key1)
      : v0_(key0 ^ 0x736f6d6570736575u),
        v1_(key1 ^ 0x646f72616e646f6du ^ 0xee),
        v2_(key0 ^ 0x6c7967656e657261u),
        v3_(key1 ^ 0x7465646279746573u) {}
  void absorb(std::uint64_t word) {
    v3_ ^= word;
    round(), round();
    v0_ ^= word;
  }
  std::uint64_t squeeze(std::uint64_t mark_v2, std::uint64_t mark_v1) {
    v2_ ^= mark_v2, v1_ ^= mark_v1;
    round(), round(), round(), round();
    return v0_ ^ v1_ ^ v2_ ^ v3_;
  }

 private:
  void round() {
    v0_ += v1_, v1_ = std::rotl(v1_, 13), v1_ ^= v0_, v0_ = std::rotl(v0_, 32);
    v2_ += v3_, v3_ = std::rotl(v3_, 16), v3_ ^= v2_;
    v0_ += v3_, v3_ = std::rotl(v3_, 21), v3_ ^= v0_;
    v2_ += v1_, v1_ = std::rotl(v1_, 17), v1_ ^= v2_, v2_ = std::rotl(v2_, 32);
  }
  std::uint64_t v0_, v1_, v2_, v3_;
};

/// The hash of `words` as little-endian bytes under the key (key0, key1).
inline Hash128 siphash128(std::span<const std::uint64_t> words, std::uint64_t key0, std::uint64_t key1) {
  SipState state(key0, key1);
  for (const std::uint64_t word : words) state.absorb(word);
  state.absorb(static_cast<std::uint64_t>(words.size() * 8) << 56);
  const std::uint64_t low = state.squeeze(0xee, 0);
  return {low, state.squeeze(0, 0xdd)};
}

}  // namespace tetloom::detail
