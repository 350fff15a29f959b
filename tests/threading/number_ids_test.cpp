#include "threading/parts/number_ids.hpp"

#include <catch2/catch.hpp>

#include <cstdint>
#include <vector>

#include "threading/comm/simulated_ranks.hpp"

using namespace tetloom;

TEST_CASE("ids are numbered over all ranks, whatever gaps there are", "[parts]") {
  const std::vector<std::vector<std::uint64_t>> ids{{7, 9, 4000000000000000000}, {}, {1, 9, 12}};
  std::vector<std::vector<std::uint64_t>> numbers(3);
  std::vector<std::size_t> counts(3);
  on_simulated_ranks(3, [&](Communicator& communicator) {
    const SharedWork work(1, {}, &communicator);
    const auto rank = static_cast<std::size_t>(communicator.rank());
    work.together([&] { numbers[rank] = number_ids(ids[rank], counts[rank], work); });
  });
  CHECK(numbers == std::vector<std::vector<std::uint64_t>>{{1, 2, 4}, {}, {0, 2, 3}});
  CHECK(counts == std::vector<std::size_t>(3, 5));
}
