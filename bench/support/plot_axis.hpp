#pragma once
// Where values lie along an axis, and which of them get a number.
#include <span>
#include <string>
#include <vector>

namespace tetloom::bench {

enum class Scale { Linear, Log };

struct Tick {
  double value = 0;
  std::string label;
};

struct Axis {
  std::string label;
  Scale scale = Scale::Linear;
  std::vector<Tick> ticks = {};  ///< empty: 1, 2 or 5 times a power of ten
  bool from_zero = true;         ///< a linear axis shows 0
};

/// "0.05", "20", "3 M": thousand, million and milliard (G) shortened.
std::string short_number(double value);

/// An axis with values on it.
class AxisRange {
 public:
  /// Covers all values and ticks. Throws std::invalid_argument when there are no values, for values that are not
  /// finite, and for values <= 0 on an axis of logarithms.
  AxisRange(const Axis& axis, std::span<const double> values);

  /// 0 where the axis begins, 1 where it ends.
  double place(double value) const;
  double low() const { return low_; }
  double high() const { return high_; }
  const std::vector<Tick>& ticks() const { return ticks_; }

 private:
  void round_linear();
  void round_logarithms();

  Scale scale_;
  double low_ = 0, high_ = 1;
  std::vector<Tick> ticks_;
};

}  // namespace tetloom::bench
