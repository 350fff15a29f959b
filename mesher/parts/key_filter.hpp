#pragma once
// Which keys are none of a few: told by a bit each.
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

/// Says of one in sixteen of the keys that are not there that they may be.
class KeyFilter {
 public:
  explicit KeyFilter(std::span<const VertKey> keys)
      : shift_(64 - static_cast<int>(std::bit_width(keys.size() * 16 | 63))),
        bits_(std::size_t{1} << (64 - shift_ - 6), 0) {
    for (const VertKey key : keys) bits_[place(key) / 64] |= std::uint64_t{1} << place(key) % 64;
  }
  bool may_hold(VertKey key) const { return (bits_[place(key) / 64] >> place(key) % 64 & 1) != 0; }

 private:
  std::size_t place(VertKey key) const { return static_cast<std::size_t>(key * 0x9e3779b97f4a7c15u >> shift_); }

  int shift_;
  std::vector<std::uint64_t> bits_;
};

}  // namespace tetloom::parts
