#pragma once
// Passes over values of which hardly any matter: many are looked at in one go, without branches, by vector
// instructions.
#include <algorithm>
#include <cstddef>
#include <span>

namespace tetloom::tets {

/// How many values are looked at in one go.
inline constexpr std::size_t kGlance = 32;

/// Calls visit(i) for every i in [begin, end) for which matters(i) holds, ascending. `matters` is cheap, and free of
/// side effects and branches; what it says of an i must not change by visits before that.
template <class Matters, class Visit>
void for_each_that(std::size_t begin, std::size_t end, const Matters& matters, Visit&& visit) {
  for (; begin + kGlance <= end; begin += kGlance) {
    unsigned any = 0;
    for (std::size_t i = 0; i < kGlance; ++i) any |= static_cast<unsigned>(matters(begin + i));
    if (any == 0) continue;
    for (std::size_t i = begin; i < begin + kGlance; ++i)
      if (matters(i)) visit(i);
  }
  for (; begin < end; ++begin)
    if (matters(begin)) visit(begin);
}

/// The least of the values, none of them NaN. Pre: there are any.
inline float least_of(std::span<const float> values) {
  float lanes[kGlance];
  std::fill(lanes, lanes + kGlance, values[0]);
  std::size_t begin = 0;
  for (; begin + kGlance <= values.size(); begin += kGlance)
    for (std::size_t i = 0; i < kGlance; ++i) lanes[i] = values[begin + i] < lanes[i] ? values[begin + i] : lanes[i];
  float least = *std::min_element(lanes, lanes + kGlance);
  for (; begin < values.size(); ++begin) least = std::min(least, values[begin]);
  return least;
}

}  // namespace tetloom::tets
