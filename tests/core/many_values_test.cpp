// Passes over values of which hardly any matter.
#include "core/tets/many_values.hpp"

#include <catch2/catch.hpp>
#include <vector>

using namespace tetloom::tets;

namespace {

std::vector<std::size_t> found_below(const std::vector<float>& values, std::size_t begin, float bound) {
  std::vector<std::size_t> found;
  for_each_that(
      begin, values.size(), [&](std::size_t i) { return values[i] < bound; },
      [&](std::size_t i) { found.push_back(i); });
  return found;
}

}  // namespace

TEST_CASE("values that matter are found wherever they stand among many") {
  for (std::size_t count = 0; count < 3 * kGlance + 2; ++count) {
    for (std::size_t at = 0; at < count; ++at) {
      std::vector<float> values(count, 1);
      values[at] = .5f;
      CHECK(found_below(values, 0, .7f) == std::vector<std::size_t>{at});
      CHECK(found_below(values, at + 1, .7f).empty());
      CHECK(least_of(values) == .5f);
    }
    CHECK(found_below(std::vector<float>(count, 1), 0, .7f).empty());
  }
}

TEST_CASE("several values that matter are found in their order") {
  std::vector<float> values(200, 1);
  const std::vector<std::size_t> places{0, 1, 31, 32, 63, 100, 199};
  for (const std::size_t at : places) values[at] = .1f;
  CHECK(found_below(values, 0, .7f) == places);
}
