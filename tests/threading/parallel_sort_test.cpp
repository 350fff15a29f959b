#include "threading/runtime/parallel_sort.hpp"
#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>
#include <cstdint>
#include <random>

using namespace tetloom;

namespace {

struct Item {
  std::uint32_t key, place;
  bool operator<(const Item& other) const { return key < other.key; }
};

std::vector<std::uint32_t> random_values(std::size_t count, std::uint32_t below, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> values(count);
  for (std::uint32_t& value : values) value = static_cast<std::uint32_t>(random()) % below;
  return values;
}

}  // namespace

TEST_CASE("a parallel sort gives the order of a serial one, whatever the length") {
  for (const std::size_t count : {0u, 1u, 2u, 16383u, 16384u, 16385u, 40000u, 131072u, 200001u})
    for (const std::uint32_t below : {3u, 1000u, 0xffffffffu}) {
      INFO(count << " values below " << below);
      std::vector<std::uint32_t> values = random_values(count, below, 7), expected = values;
      std::sort(expected.begin(), expected.end());
      parallel_sort(values, TaskRunner(3));
      CHECK(values == expected);
      values = random_values(count, below, 7);
      expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
      parallel_sort_unique(values, TaskRunner(3));
      CHECK(values == expected);
    }
}

TEST_CASE("a parallel sort puts what is equal in an order that does not depend on threads") {
  const auto sorted = [](int threads) {
    std::vector<Item> items;
    for (const std::uint32_t key : random_values(100000, 50, 3))
      items.push_back({key, static_cast<std::uint32_t>(items.size())});
    parallel_sort(items, TaskRunner(threads));
    std::vector<std::uint32_t> places;
    for (const Item& item : items) places.push_back(item.place);
    return places;
  };
  const auto one = sorted(1);
  CHECK(sorted(2) == one);
  CHECK(sorted(8) == one);
}
