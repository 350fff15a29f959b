#pragma once
// Sums of floating-point numbers that do not depend on the order in which they are added up.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tetloom {

/// The exact sum of up to 2^62 numbers, in fixed point over the whole range of doubles (after Kulisch's long
/// accumulator): any order of additions, and any way of adding sums up, ends in the same bits. About 3 ns per number.
class ExactSum {
 public:
  void add(double x) {
    const auto bits = std::bit_cast<std::uint64_t>(x);
    const auto exponent = static_cast<std::size_t>(bits >> 52 & 0x7ff);
    if (exponent == 0x7ff) return add_special(x);
    // x = mantissa · 2^(place - 1074)
    const std::uint64_t mantissa = (bits & kMantissa) | (exponent > 0 ? kMantissa + 1 : 0);
    const std::size_t place = exponent > 0 ? exponent - 1 : 0, shift = place % kBits;
    const auto sign = x < 0 ? std::int64_t{-1} : std::int64_t{1};
    std::int64_t* const word = &words_[place / kBits];
    word[0] += sign * static_cast<std::int64_t>(mantissa << shift & kWord);
    word[1] += sign * static_cast<std::int64_t>(mantissa >> (kBits - shift) & kWord);
    word[2] += sign * static_cast<std::int64_t>(mantissa >> kBits >> (kBits - shift));
    if (++added_ == kMostUncarried) carry();
  }

  void add(const ExactSum& other) {
    ExactSum carried = other;
    carried.carry(), carry();
    for (std::size_t i = 0; i < words_.size(); ++i) words_[i] += carried.words_[i];
    carry();
  }

  /// Words that may be added up as integers, those of up to 2^30 sums; `carry` is to be called before and afterwards.
  std::span<std::int64_t> words() { return words_; }
  /// Brings the words into range.
  void carry() {
    std::int64_t carried = 0;
    for (std::size_t i = 0; i + 1 < kWords; ++i) {
      const std::int64_t sum = words_[i] + carried;
      carried = sum >> kBits;
      words_[i] = sum & static_cast<std::int64_t>(kWord);
    }
    words_[kWords - 1] += carried;
    added_ = 0;
  }

  /// The double next to the sum; infinite or not a number where one of the numbers was.
  double value() const {
    if (special(2) > 0 || (special(0) > 0 && special(1) > 0)) return NAN;
    if (special(0) + special(1) > 0) return special(0) > 0 ? HUGE_VAL : -HUGE_VAL;
    ExactSum sum = *this;
    sum.carry();
    if (sum.words_[kWords - 1] >= 0) return sum.magnitude();
    for (std::int64_t& word : sum.words_) word = -word;
    sum.carry();
    return -sum.magnitude();
  }

 private:
  static constexpr std::size_t kBits = 32, kWords = 68, kSpecials = 3;
  static constexpr std::uint64_t kMantissa = (std::uint64_t{1} << 52) - 1, kWord = (std::uint64_t{1} << kBits) - 1;
  static constexpr std::uint32_t kMostUncarried = std::uint32_t{1} << 29;

  // Counts of +inf, -inf and what is not a number.
  std::int64_t special(std::size_t kind) const { return words_[kWords + kind]; }
  void add_special(double x) { ++words_[kWords + (std::isnan(x) ? 2 : x > 0 ? 0 : 1)]; }

  // Of words in range, none of them negative. The bits beyond the first 64 decide about halves alone.
  double magnitude() const {
    std::size_t top = kWords;
    while (top > 0 && words_[top - 1] == 0) --top;
    if (top == 0) return 0;
    const auto word = [&](std::size_t back) {
      return top > back ? static_cast<std::uint64_t>(words_[top - 1 - back]) : std::uint64_t{0};
    };
    const auto zeros = static_cast<std::size_t>(std::countl_zero(static_cast<std::uint32_t>(word(0))));
    std::uint64_t window = word(0) << (kBits + zeros) | word(1) << zeros | word(2) >> (kBits - zeros);
    bool more = (word(2) << zeros & kWord) != 0;
    for (std::size_t back = 3; back < top; ++back) more = more || word(back) != 0;
    window |= more ? 1 : 0;
    return std::ldexp(static_cast<double>(window),
                      static_cast<int>(kBits * top) - static_cast<int>(2 * kBits + zeros) - 1074);
  }

  std::array<std::int64_t, kWords + kSpecials> words_{};
  std::uint32_t added_ = 0;
};

}  // namespace tetloom
