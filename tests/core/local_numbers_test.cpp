// Local numbers against a map, over many tasks with one object; lists.
#include <catch2/catch.hpp>
#include <map>
#include <random>

#include "core/base/lists.hpp"
#include "core/base/local_numbers.hpp"

using namespace tetloom;

TEST_CASE("local numbers follow each other in the order of adding, or ascending", "[local_numbers]") {
  std::mt19937 random(3);
  LocalNumbers numbers(50);
  for (int task = 0; task < 40; ++task) {
    numbers.clear();
    const std::uint32_t most = 1 + random() % 50;
    numbers.set_item_count(most);
    std::map<std::uint32_t, std::uint32_t> expected;
    for (unsigned i = random() % 30; i > 0; --i) {
      const std::uint32_t item = random() % most;
      const auto number = expected.try_emplace(item, static_cast<std::uint32_t>(expected.size())).first->second;
      REQUIRE(numbers.add(item) == number);
    }
    if (task % 2 == 1) {
      numbers.sort();
      std::uint32_t next = 0;
      for (auto& [item, number] : expected) number = next++;
    }
    REQUIRE(numbers.size() == expected.size());
    for (std::uint32_t item = 0; item < most; ++item)
      REQUIRE(numbers[item] == (expected.contains(item) ? expected[item] : kNone));
    for (std::uint32_t i = 0; i < numbers.size(); ++i) REQUIRE(numbers[numbers.items()[i]] == i);
  }
}

TEST_CASE("lists are joined in their order, and sorted with each value once", "[local_numbers]") {
  std::vector<int> list = joined(std::vector<std::vector<int>>{{3, 1}, {}, {3, 2}});
  CHECK(list == std::vector<int>{3, 1, 3, 2});
  sort_unique(list);
  CHECK(list == std::vector<int>{1, 2, 3});
}
