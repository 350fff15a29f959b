#pragma once
// Random metrics for tests.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "tetloom/metric.hpp"

namespace tetloom::adapt {

class RandomTensors {
 public:
  explicit RandomTensors(unsigned seed) : engine_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 vector() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
  /// A right-handed orthonormal basis.
  std::array<Vec3, 3> basis() {
    for (;;) {
      const Vec3 a = vector(), b = vector();
      if (norm(a) < 0.1 || norm(cross(a, b)) < 0.1) continue;
      const Vec3 u = normalized(a), w = normalized(cross(a, b));
      return {u, cross(w, u), w};
    }
  }
  /// Sizes between `h` and `h` * `aspect`, any directions.
  EigenSystem metric(double h, double aspect) {
    EigenSystem e;
    e.vectors = basis();
    for (double& value : e.values) value = std::pow(h * std::pow(aspect, uniform(0, 1)), -2);
    return e;
  }
  /// Entries in [-1, 1]: eigenvalues of any sign.
  Tensor tensor() {
    return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
  }

 private:
  std::mt19937_64 engine_;
};

inline double largest_entry(const Tensor& m) {
  return std::max({std::abs(m.xx), std::abs(m.xy), std::abs(m.yy), std::abs(m.xz), std::abs(m.yz), std::abs(m.zz)});
}

}  // namespace tetloom::adapt
