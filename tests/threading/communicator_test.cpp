#include "tetloom/communicator.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <mutex>
#include <thread>

#include "tests/threading/communicators.hpp"
#include "tests/threading/disordering_communicator.hpp"
#include "tests/threading/part_program.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

Bytes filled(std::size_t size, int value) { return Bytes(size, static_cast<std::byte>(value)); }

}  // namespace

TEST_CASE("every part lives on one rank, in blocks") {
  const auto communicator = make_communicator();
  for (const std::size_t count : {0u, 1u, 2u, 3u, 5u, 16u, 101u}) {
    std::vector<PartId> own;
    for (std::size_t part = 0; part < count; ++part)
      if (communicator->rank_of(PartId(part), count) == communicator->rank()) own.push_back(PartId(part));
    CHECK(communicator->parts_of_rank(count) == own);
    std::int64_t total[] = {static_cast<std::int64_t>(own.size())};
    communicator->sum(total);
    CHECK(total[0] == static_cast<std::int64_t>(count));
  }
}

TEST_CASE("all ranks of a test share one machine") {
  const auto communicator = make_communicator();
  CHECK(communicator->ranks_on_machine() == communicator->rank_count());
}

TEST_CASE("collectives give every rank the same") {
  const auto communicator = make_communicator();
  const int ranks = communicator->rank_count(), rank = communicator->rank();
  std::int64_t sums[] = {rank + 1, std::int64_t{1} << 40, -rank};
  communicator->sum(sums);
  CHECK(sums[0] == ranks * (ranks + 1) / 2);
  CHECK(sums[1] == ranks * (std::int64_t{1} << 40));
  CHECK(sums[2] == -ranks * (ranks - 1) / 2);
  double largest[] = {static_cast<double>(rank), -static_cast<double>(rank)};
  communicator->max(largest);
  CHECK(largest[0] == ranks - 1);
  CHECK(largest[1] == 0.0);
  for (const std::size_t size : {std::size_t{0}, std::size_t{3}, std::size_t{100'001}}) {
    const auto gathered = communicator->all_gather(filled(size * rank, rank));
    REQUIRE(gathered.size() == static_cast<std::size_t>(ranks));
    for (int from = 0; from < ranks; ++from) CHECK((gathered[from] == filled(size * from, from)));
  }
}

TEST_CASE("messages of all sizes arrive once and whole, in their own run") {
  const auto communicator = make_communicator();
  const int ranks = communicator->rank_count(), rank = communicator->rank();
  const std::vector<std::size_t> sizes{0, 1, 9'999, 10'000, 10'001, 40'000, 100'000, 1'234'567};
  for (int run = 0; run < (ranks > 1 ? 10 : 30); ++run) {
    std::mutex mutex;
    std::vector<std::pair<std::uint32_t, std::size_t>> seen;  // sender's rank, size
    bool good = true;
    communicator->open([&](Message&& message) {
      const std::lock_guard lock(mutex);
      good = good && message.step == static_cast<std::uint32_t>(run) && message.to.value == std::uint32_t(rank) &&
             message.bytes == filled(message.bytes.size(), run);
      seen.push_back({message.from.value, message.bytes.size()});
    });
    for (const std::size_t size : sizes)
      for (int to = 0; to < ranks; ++to)
        communicator->send({PartId(rank), PartId(to), static_cast<std::uint32_t>(run), filled(size, run)}, to);
    // Some ranks are late, so that others are a run ahead.
    if (run % ranks == rank) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    communicator->close();
    std::sort(seen.begin(), seen.end());
    std::vector<std::pair<std::uint32_t, std::size_t>> expected;
    for (int from = 0; from < ranks; ++from)
      for (const std::size_t size : sizes) expected.push_back({static_cast<std::uint32_t>(from), size});
    CHECK(good);
    CHECK((seen == expected));
  }
}

TEST_CASE("a failure is heard on all other ranks, and by the next run no more") {
  const auto communicator = make_communicator();
  for (int failing = 0; failing < communicator->rank_count(); ++failing) {
    const bool here = failing == communicator->rank();
    communicator->open([](Message&&) {});
    for (int i = 0; here && i < 2; ++i) communicator->announce_failure();
    while (!here && !communicator->failed_elsewhere()) std::this_thread::yield();
    communicator->close();
    CHECK(communicator->failed_elsewhere() == !here);
    communicator->open([](Message&&) {});
    CHECK_FALSE(communicator->failed_elsewhere());
    communicator->close();
  }
}

TEST_CASE("late messages in any order do not change a result") {
  const auto communicator = make_communicator();
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    CAPTURE(seed);
    const std::size_t count = 5 + 3 * seed;
    const std::vector<Graph> graphs{ring(count), random_directed(count, seed), random_directed(count, seed + 50),
                                    grid(count, 1)};
    DisorderingCommunicator disordering(*communicator, seed);
    const TaskRunner runner(1 + static_cast<int>(seed % 3));
    PartProgram disturbed(disordering, count, graphs), undisturbed(*communicator, count, graphs);
    Schedule(disordering, runner, count).run(disturbed.steps());
    Schedule(*communicator, runner, count).run(undisturbed.steps());
    const Values values = disturbed.gathered();
    CHECK(values == undisturbed.gathered());
    CHECK(values == serial_result(count, graphs));
  }
}
