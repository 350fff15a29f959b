#pragma once
// Signed integers of W 64-bit words in two's complement, and coordinate differences scaled to one word. Private to
// core/predicates: for the common case that a few words are enough, many times faster than integer_detail.hpp.
//
// Pre: no result overflows; the callers know from the widths of their operands. Never allocates.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tetloom::detail {

/// A whole number of W words, in two's complement.
template <std::size_t W>
struct Fixed {
  std::array<std::uint64_t, W> words{};

  bool negative() const { return words[W - 1] >> 63 != 0; }
  int sign() const {
    if (negative()) return -1;
    return std::any_of(words.begin(), words.end(), [](std::uint64_t word) { return word != 0; }) ? 1 : 0;
  }
};

template <std::size_t W>
Fixed<W> operator+(const Fixed<W>& a, const Fixed<W>& b) {
  Fixed<W> sum;
  unsigned __int128 carry = 0;
  for (std::size_t i = 0; i < W; ++i) {
    carry += static_cast<unsigned __int128>(a.words[i]) + b.words[i];
    sum.words[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  return sum;
}

template <std::size_t W>
Fixed<W> operator-(const Fixed<W>& a, const Fixed<W>& b) {
  Fixed<W> difference;
  std::uint64_t borrow = 0;
  for (std::size_t i = 0; i < W; ++i) {
    const unsigned __int128 taken = static_cast<unsigned __int128>(b.words[i]) + borrow;
    borrow = taken > a.words[i] ? 1 : 0;
    difference.words[i] = a.words[i] - static_cast<std::uint64_t>(taken);
  }
  return difference;
}

/// The unsigned product, from which what the words of a negative factor stand for too much is taken away.
template <std::size_t A, std::size_t B>
Fixed<A + B> operator*(const Fixed<A>& a, const Fixed<B>& b) {
  Fixed<A + B> product;
  for (std::size_t i = 0; i < A; ++i) {
    unsigned __int128 carry = 0;
    for (std::size_t j = 0; j < B; ++j) {
      carry += static_cast<unsigned __int128>(a.words[i]) * b.words[j] + product.words[i + j];
      product.words[i + j] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    product.words[i + B] = static_cast<std::uint64_t>(carry);
  }
  const auto take_from_top = [&product](const auto& other, std::size_t first) {
    std::uint64_t borrow = 0;
    for (std::size_t i = 0; first + i < A + B; ++i) {
      const unsigned __int128 taken = static_cast<unsigned __int128>(other.words[i]) + borrow;
      borrow = taken > product.words[first + i] ? 1 : 0;
      product.words[first + i] -= static_cast<std::uint64_t>(taken);
    }
  };
  if (a.negative()) take_from_top(b, A);
  if (b.negative()) take_from_top(a, B);
  return product;
}

/// Differences minuend[i] - subtrahend[i], all scaled by one power of two so that they are integers below 2^61 in
/// magnitude. False where that is not possible. After Knuth's exact difference of two doubles: a high and a low part.
template <std::size_t N>
bool scale_differences(const std::array<double, N>& minuend, const std::array<double, N>& subtrahend,
                       std::array<Fixed<1>, N>& scaled) {
  std::array<double, N> high, low;
  double largest = 0;
  for (std::size_t i = 0; i < N; ++i) {
    const double a = minuend[i], b = subtrahend[i], d = a - b, back = a - d;
    high[i] = d;
    low[i] = (a - (d + back)) + (back - b);
    largest = std::max(largest, std::abs(d));
  }
  if (largest == 0) return true;
  if (!(largest > 1e-250 && largest < 1e250)) return false;
  const double scale = std::ldexp(1.0, 60 - std::ilogb(largest));
  for (std::size_t i = 0; i < N; ++i) {
    const double h = high[i] * scale, l = low[i] * scale;
    const auto hi = static_cast<std::int64_t>(h), lo = static_cast<std::int64_t>(l);
    if (static_cast<double>(hi) != h || static_cast<double>(lo) != l) return false;
    scaled[i].words[0] = static_cast<std::uint64_t>(hi + lo);
  }
  return true;
}

}  // namespace tetloom::detail
