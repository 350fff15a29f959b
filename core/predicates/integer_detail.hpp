#pragma once
// Signed integers of up to N 64-bit words on the stack, and doubles scaled to them. Private to core/predicates.
//
// Pre: no result needs more than N words; the callers choose N from the exponents of their input. Never allocates.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

namespace tetloom::detail {

__extension__ using Word2 = unsigned __int128;

/// Sign and magnitude; `size` words are significant, the highest of them is not 0, and zero has none.
template <int N>
struct Integer {
  int size = 0;
  bool negative = false;
  std::uint64_t words[N];

  Integer() {}
  Integer(const Integer& other) { *this = other; }
  Integer& operator=(const Integer& other) {
    size = other.size, negative = other.negative;
    std::copy(other.words, other.words + other.size, words);
    return *this;
  }
  int sign() const { return size == 0 ? 0 : negative ? -1 : 1; }
};

template <int N>
int compare_magnitude(const Integer<N>& a, const Integer<N>& b) {
  if (a.size != b.size) return a.size < b.size ? -1 : 1;
  for (int i = a.size - 1; i >= 0; --i) {
    if (a.words[i] != b.words[i]) return a.words[i] < b.words[i] ? -1 : 1;
  }
  return 0;
}

// |a| + |b|
template <int N>
Integer<N> add_magnitude(const Integer<N>& a, const Integer<N>& b) {
  const Integer<N>&longer = a.size >= b.size ? a : b, &shorter = a.size >= b.size ? b : a;
  Integer<N> sum;
  Word2 carry = 0;
  for (int i = 0; i < longer.size; ++i) {
    carry += longer.words[i];
    if (i < shorter.size) carry += shorter.words[i];
    sum.words[i] = static_cast<std::uint64_t>(carry);
    carry >>= 64;
  }
  sum.size = longer.size;
  if (carry != 0) sum.words[sum.size++] = static_cast<std::uint64_t>(carry);
  return sum;
}

// |a| - |b|; pre: |a| >= |b|
template <int N>
Integer<N> subtract_magnitude(const Integer<N>& a, const Integer<N>& b) {
  Integer<N> difference;
  std::uint64_t borrow = 0;
  for (int i = 0; i < a.size; ++i) {
    const Word2 taken = static_cast<Word2>(i < b.size ? b.words[i] : 0) + borrow;
    borrow = taken > a.words[i] ? 1 : 0;
    difference.words[i] = a.words[i] - static_cast<std::uint64_t>(taken);
  }
  difference.size = a.size;
  while (difference.size > 0 && difference.words[difference.size - 1] == 0) --difference.size;
  return difference;
}

template <int N>
Integer<N> operator-(Integer<N> a) {
  a.negative = !a.negative;
  return a;
}

template <int N>
Integer<N> operator+(const Integer<N>& a, const Integer<N>& b) {
  Integer<N> sum;
  if (a.negative == b.negative) {
    sum = add_magnitude(a, b);
    sum.negative = a.negative;
  } else if (compare_magnitude(a, b) >= 0) {
    sum = subtract_magnitude(a, b);
    sum.negative = a.negative;
  } else {
    sum = subtract_magnitude(b, a);
    sum.negative = b.negative;
  }
  return sum;
}

template <int N>
Integer<N> operator-(const Integer<N>& a, const Integer<N>& b) {
  return a + (-b);
}

template <int N>
Integer<N> operator*(const Integer<N>& a, const Integer<N>& b) {
  Integer<N> product;
  if (a.size == 0 || b.size == 0) return product;
  product.size = a.size + b.size;
  product.negative = a.negative != b.negative;
  std::fill(product.words, product.words + product.size, 0);
  for (int i = 0; i < a.size; ++i) {
    Word2 carry = 0;
    for (int j = 0; j < b.size; ++j) {
      carry += static_cast<Word2>(a.words[i]) * b.words[j] + product.words[i + j];
      product.words[i + j] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    product.words[i + b.size] = static_cast<std::uint64_t>(carry);
  }
  if (product.words[product.size - 1] == 0) --product.size;
  return product;
}

/// The lowest and one past the highest bit that any of some doubles has set, as powers of two.
struct BitRange {
  int lowest = 0, end = 0;

  explicit BitRange(std::span<const double> values) {
    bool any = false;
    for (const double value : values) {
      if (value == 0) continue;
      int exponent = 0;
      const auto mantissa = static_cast<std::uint64_t>(std::ldexp(std::abs(std::frexp(value, &exponent)), 53));
      const int low = exponent - 53 + std::countr_zero(mantissa);
      lowest = any ? std::min(lowest, low) : low;
      end = any ? std::max(end, exponent) : exponent;
      any = true;
    }
  }
  int bits() const { return end - lowest; }
};

/// value / 2^lowest. Pre: that is an integer.
template <int N>
Integer<N> scaled_integer(double value, int lowest) {
  Integer<N> result;
  if (value == 0) return result;
  int exponent = 0;
  auto mantissa = static_cast<std::uint64_t>(std::ldexp(std::abs(std::frexp(value, &exponent)), 53));
  const int zeros = std::countr_zero(mantissa);
  mantissa >>= zeros;
  const int shift = exponent - 53 + zeros - lowest;
  const Word2 shifted = static_cast<Word2>(mantissa) << (shift % 64);
  result.negative = value < 0;
  result.size = shift / 64 + 2;
  std::fill(result.words, result.words + result.size, 0);
  result.words[shift / 64] = static_cast<std::uint64_t>(shifted);
  result.words[shift / 64 + 1] = static_cast<std::uint64_t>(shifted >> 64);
  while (result.words[result.size - 1] == 0) --result.size;
  return result;
}

}  // namespace tetloom::detail
