#pragma once
// Random parameters that are the same with every compiler and library.
#include <cmath>
#include <cstdint>
#include <random>

#include "tetloom/vec.hpp"

namespace tetloom::test {

class Random {
 public:
  /// Families with the same seed differ by their `stream`.
  Random(std::uint64_t stream, std::uint64_t seed) : engine_(0x9e3779b97f4a7c15u * (stream + 1) + seed) {}

  /// In [lo, hi).
  double uniform(double lo, double hi) { return lo + (hi - lo) * 0x1p-53 * static_cast<double>(engine_() >> 11); }
  /// All orders of magnitude alike. Pre: 0 < lo < hi.
  double log_uniform(double lo, double hi) { return std::exp(uniform(std::log(lo), std::log(hi))); }
  /// In lo … hi, both ends included.
  int integer(int lo, int hi) { return lo + static_cast<int>(uniform(0, 1) * (hi - lo + 1)); }
  bool chance(double probability) { return uniform(0, 1) < probability; }
  Vec3 direction() {
    const double z = uniform(-1, 1), angle = uniform(0, 6.283185307179586), r = std::sqrt(1 - z * z);
    return {r * std::cos(angle), r * std::sin(angle), z};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace tetloom::test
