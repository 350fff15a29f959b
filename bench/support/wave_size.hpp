#pragma once
// A size that varies everywhere: a triangle wave between h and 8 h along a slanted direction.
#include <cmath>
#include <cstdio>
#include <string>

#include "tetloom/size_field.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::bench {

/// From `smallest`, which it is where the direction's coordinate is `start`, the size grows by `gradient` per unit of
/// distance up to kWaveRatio times that, falls again, and so on. A gradient of 0 is one size everywhere.
struct WaveSize {
  static constexpr double kWaveRatio = 8;
  static constexpr Vec3 kDirection{2.0 / 7, 3.0 / 7, 6.0 / 7};  // of length 1, along no axis

  double smallest = 1, gradient = 0, start = 0;

  bool is_uniform() const { return gradient == 0; }
  double largest() const { return is_uniform() ? smallest : kWaveRatio * smallest; }
  /// From one trough to the next. Pre: not uniform.
  double period() const { return 2 * (largest() - smallest) / gradient; }

  double at(const Vec3& x) const {
    if (is_uniform()) return smallest;
    return smallest + gradient * std::abs(std::remainder(dot(x, kDirection) - start, period()));
  }

  /// The same as an expression of gmsh's MathEval field. Pre: not uniform.
  std::string expression() const {
    constexpr double kPi = 3.14159265358979323846;
    char text[256];
    std::snprintf(text, sizeof(text), "%.17g+%.17g*abs(asin(sin(%.17g*((2*x+3*y+6*z)/7-(%.17g)))))", smallest,
                  gradient * period() / kPi, kPi / period(), start);
    return text;
  }
};

}  // namespace tetloom::bench
