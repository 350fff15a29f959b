// What ranks compute and send between two meetings, and what a network takes for it.
#include "bench/support/measured_ranks.hpp"

#include <time.h>

#include <catch2/catch.hpp>

using namespace tetloom;
using namespace tetloom::bench;

namespace {

/// Uses so many seconds of the processor.
void compute(double seconds) {
  const auto used = [] {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  };
  for (const double begin = used(); used() < begin + seconds;) continue;
}

}  // namespace

TEST_CASE("all ranks wait for the slowest of each phase and for the one that sends most") {
  const RankPhases phases{{{1.0, 100, false}, {0.5, 10, true}, {0, 0, false}},
                          {{2.0, 300, false}, {0.25, 20, true}, {0, 0, false}},
                          {{0.5, 0, false}, {0.25, 30, true}, {4.0, 0, false}}};
  CHECK(compute_seconds(phases) == Approx(6.5));
  CHECK(processor_seconds(phases) == Approx(8.5));
  CHECK(most_sent_bytes(phases) == 320);
  // Two latencies in each of three phases, the most of the first, all of the second.
  CHECK(predict_seconds(phases, {0.01, 1000}) == Approx(6.5 + 3 * 2 * 0.01 + 0.3 + 0.06));
  CHECK(predict_seconds({phases[0]}, {0.01, 1000}) == Approx(1.5));
}

TEST_CASE("phases end with collective calls; waiting and what comes before the start are in none") {
  const RankPhases phases = measure_ranks(3, [](Communicator& ranks, const std::function<void()>& start) {
    ranks.all_gather(Bytes(1000));
    start();
    if (ranks.rank() == 1) compute(0.05);
    std::int64_t one = 1;
    ranks.sum(std::span(&one, 1));
    ranks.all_gather(Bytes(static_cast<std::size_t>(10 * ranks.rank())));
    ranks.open([](Message&&) {});
    if (ranks.rank() == 2) ranks.send({PartId(2), PartId(0), 0, Bytes(7)}, 0);
    if (ranks.rank() == 2) ranks.send({PartId(2), PartId(2), 0, Bytes(9)}, 2);
    ranks.close();
  });
  REQUIRE(phases.size() == 3);
  for (const auto& of_rank : phases) REQUIRE(of_rank.size() == 5);  // sum, gather, open, close, the end
  CHECK(phases[1][0].seconds >= 0.05);
  CHECK(phases[0][0].seconds < phases[1][0].seconds);
  for (std::size_t rank = 0; rank < 3; ++rank) {
    CHECK(phases[rank][1].is_gathered);
    CHECK(phases[rank][1].bytes == 10 * rank);
    CHECK(phases[rank][3].bytes == (rank == 2 ? 7 : 0));
  }
}

TEST_CASE("one rank sends nothing") {
  const RankPhases phases = measure_ranks(1, [](Communicator& ranks, const std::function<void()>& start) {
    start();
    ranks.all_gather(Bytes(1000));
  });
  CHECK(most_sent_bytes(phases) == 0);
}
