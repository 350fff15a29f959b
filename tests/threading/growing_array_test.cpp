#include "tetloom/storage.hpp"

#include <catch2/catch.hpp>
#include <cstdint>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include "core/base/page_size.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;

namespace {

using Array = GrowingArray<std::uint64_t>;

// More bytes than are kept on the heap.
constexpr std::size_t kLarge = 100'000;

Array counted(std::size_t count) {
  Array array;
  array.resize_for_overwrite(count);
  std::iota(array.begin(), array.end(), std::uint64_t{0});
  return array;
}

bool is_counted(const Array& array, std::size_t count) {
  if (array.size() != count) return false;
  for (std::size_t i = 0; i < count; ++i)
    if (array[i] != i) return false;
  return true;
}

}  // namespace

TEST_CASE("values stay while an array grows from the heap into pages and back") {
  Array array;
  for (std::uint64_t i = 0; i < kLarge; ++i) array.push_back(i);
  CHECK(is_counted(array, kLarge));
  for (const std::size_t count : {kLarge / 2, std::size_t{32'769}, std::size_t{32'768}, std::size_t{32'767},
                                  std::size_t{10}, std::size_t{1}, std::size_t{0}}) {
    array.resize(count);
    array.shrink_to_fit();
    CHECK(array.capacity() == count);
    CHECK(is_counted(array, count));
  }
}

TEST_CASE("an array does what a vector does under random changes") {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    Array array;
    std::vector<std::uint64_t> expected;
    for (int change = 0; change < 60; ++change) {
      const std::size_t count = random() % (seed % 5 == 0 ? 60'000 : 60);
      const std::uint64_t value = random();
      switch (random() % 7) {
        case 0: array.resize(count, value), expected.resize(count, value); break;
        case 1: array.push_back(value), expected.push_back(value); break;
        case 2: {
          const std::vector<std::uint64_t> more(count, value);
          array.append(more), expected.insert(expected.end(), more.begin(), more.end());
          break;
        }
        case 3: array.reserve(count); break;
        case 4: array.shrink_to_fit(); break;
        case 5: array = Array(array); break;
        default:
          if (random() % 4 == 0) array.clear(), expected.clear();
      }
      REQUIRE(array.size() == expected.size());
      REQUIRE(array.capacity() >= array.size());
      REQUIRE(std::equal(array.begin(), array.end(), expected.begin()));
    }
  }
}

TEST_CASE("an element of the array itself can be put in again while the array grows") {
  for (const std::size_t count : {std::size_t{1}, std::size_t{8}, std::size_t{32'767}, std::size_t{32'768}, kLarge}) {
    Array array = counted(count);
    array.shrink_to_fit();
    array.push_back(array[count - 1]);
    CHECK(array.back() == count - 1);
    array.shrink_to_fit();
    array.resize(2 * count + 1, array[count / 2]);
    CHECK(array.back() == count / 2);
  }
}

TEST_CASE("copies are apart, and what was moved from is empty") {
  for (const std::size_t count : {std::size_t{0}, std::size_t{5}, kLarge}) {
    Array array = counted(count), copy = array;
    CHECK(copy == array);
    for (std::uint64_t& value : copy) value += 1;
    CHECK(is_counted(array, count));
    const std::uint64_t* data = array.data();
    Array moved = std::move(array);
    CHECK(moved.data() == data);
    CHECK(is_counted(moved, count));
    array = counted(3);
    CHECK(is_counted(array, 3));
    array = std::move(moved);
    CHECK(is_counted(array, count));
    Array& same = array;
    array = same;
    CHECK(is_counted(array, count));
  }
}

TEST_CASE("released arrays hold no memory and can be used again") {
  Array array = counted(kLarge);
  array.clear();
  CHECK(array.empty());
  CHECK(array.capacity() >= kLarge);
  array.release();
  CHECK(array.capacity() == 0);
  CHECK(array.data() == nullptr);
  array.release();
  array.append(std::span<const std::uint64_t>());
  CHECK(array.empty());
  array.append(std::vector<std::uint64_t>{0, 1, 2});
  CHECK(is_counted(array, 3));
}

TEST_CASE("appending grows by a half at least, so that many appends are cheap") {
  Array array;
  std::size_t moves = 0, capacity = 0;
  const std::vector<std::uint64_t> few(3, 1);
  while (array.size() < kLarge) {
    array.append(few);
    if (std::exchange(capacity, array.capacity()) != array.capacity()) ++moves;
  }
  CHECK(moves < 40);
}

TEST_CASE("a wish for huge pages leaves the storage as it is") {
  std::vector<std::uint32_t> values(3 << 20);
  std::iota(values.begin(), values.end(), 7u);
  for (const std::size_t count : {std::size_t{0}, std::size_t{5}, std::size_t{1} << 19, values.size() - 3})
    want_huge_pages(std::span(values).subspan(3, count));
  for (std::uint32_t i = 0; i < values.size(); ++i)
    if (values[i] != i + 7) FAIL("it has changed");
}

TEST_CASE("room made by several threads leaves the items as they are and is not moved from") {
  const TaskRunner runner(2);
  std::vector<std::uint32_t> values(5);
  std::iota(values.begin(), values.end(), 7u);
  const std::size_t count = (3 << 20) + 1;
  reserve_touched(values, count, runner);
  REQUIRE(values.capacity() >= count);
  const std::uint32_t* const begin = values.data();
  values.resize(count);
  reserve_touched(values, 3, runner);  // is there
  CHECK(values.data() == begin);
  CHECK(std::vector<std::uint32_t>(values.begin(), values.begin() + 6) ==
        std::vector<std::uint32_t>{7, 8, 9, 10, 11, 0});
  std::vector<std::uint32_t> none;
  reserve_touched(none, 0, runner);
  CHECK(none.empty());
}
