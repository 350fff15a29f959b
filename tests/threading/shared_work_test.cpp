// Ranks that share the items of loops, and what becomes of one that fails.
#include "threading/comm/shared_work.hpp"
#include "tetloom/tasks.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <new>
#include <numeric>
#include <stdexcept>

#include "core/base/lists.hpp"
#include "tests/threading/communicators.hpp"
#include "threading/comm/simulated_ranks.hpp"
#include "threading/comm/sort_on_ranks.hpp"

using namespace tetloom;

namespace {

std::vector<std::uint32_t> list_of(std::size_t i) {
  std::vector<std::uint32_t> list(i % 5);
  std::iota(list.begin(), list.end(), static_cast<std::uint32_t>(i));
  return list;
}

const std::vector<double> kAmounts{3, 1, 4, 1, 5, 9, 2, 6, 5, 3, 5};

void check_loops(const SharedWork& work, Communicator& communicator) {
  std::vector<std::int64_t> made(kAmounts.size(), 0);
  std::vector<std::vector<std::uint32_t>> lists;
  std::vector<double> values(1000, 0.0), owned(1000, 0.0);
  std::atomic<int> strange{0};
  const auto owner_of = [&](std::size_t i) { return static_cast<int>(i / 90) % work.rank_count(); };
  work.together([&] {
    lists = work.make_lists<std::uint32_t>(kAmounts, [&](std::size_t i) {
      ++made[i];
      return list_of(i);
    });
    work.fill<double>(values, 7, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) values[i] = 0.1 * static_cast<double>(i);
    });
    work.fill<double>(owned, 7, owner_of, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        strange += owner_of(i) != work.rank();
        owned[i] = 0.1 * static_cast<double>(i);
      }
    });
  });
  CHECK(strange == 0);
  CHECK(owned == values);
  communicator.sum(made);
  CHECK(made == std::vector<std::int64_t>(kAmounts.size(), 1));
  for (std::size_t i = 0; i < kAmounts.size(); ++i) CHECK(lists[i] == list_of(i));
  for (std::size_t i = 0; i < values.size(); ++i) REQUIRE(values[i] == 0.1 * static_cast<double>(i));
}

std::optional<Diagnostic> outcome(const SharedWork& work, const std::function<void()>& body) {
  try {
    work.together(body);
  } catch (const Error& error) {
    return error.diagnostic();
  }
  return std::nullopt;
}

Diagnostic trouble(int rank) {
  return {ErrorCode::EdgeFailed, "trouble on rank " + std::to_string(rank), {{{1, 7}, "rim"}}, Vec3{1, 2, 3}, {4}};
}

void check_trouble(const std::optional<Diagnostic>& told, int rank) {
  REQUIRE(told);
  CHECK(told->code == ErrorCode::EdgeFailed);
  CHECK(told->message == "trouble on rank " + std::to_string(rank));
  REQUIRE(told->entities.size() == 1);
  CHECK(told->entities[0].entity == ModelEntity{1, 7});
  CHECK(told->entities[0].name == "rim");
  CHECK(told->point == Vec3{1, 2, 3});
}

void run_loop(const SharedWork& work, const std::function<void(std::size_t)>& body = {}) {
  std::vector<std::uint8_t> values(50);
  work.fill<std::uint8_t>(values, 1, [&](std::size_t begin, std::size_t) {
    if (body) body(begin);
  });
}

}  // namespace

TEST_CASE("each item is made on one rank, and all ranks have what was made of it") {
  const auto communicator = make_communicator();
  for (const int threads : {1, 3}) check_loops({threads, {}, communicator.get()}, *communicator);
  check_loops(TaskRunner(2), *make_thread_communicator());
}

TEST_CASE("loops are shared by any number of ranks") {
  for (const int ranks : {1, 2, 3, 20}) {
    std::atomic<int> made{0};
    on_simulated_ranks(ranks, [&](Communicator& communicator) {
      const SharedWork work(1, {}, &communicator);
      std::vector<std::vector<std::uint32_t>> lists;
      work.together([&] {
        lists = work.make_lists<std::uint32_t>(kAmounts, [&](std::size_t i) {
          ++made;
          return list_of(i);
        });
      });
      for (std::size_t i = 0; i < lists.size(); ++i)
        if (lists[i] != list_of(i)) throw Error(ErrorCode::Internal, "another list");
    });
    CHECK(made == static_cast<int>(kAmounts.size()));
  }
}

namespace {

void check_own(const SharedWork& work, int rank, int ranks) {
  const auto require = [](bool holds) {
    if (!holds) throw Error(ErrorCode::Internal, "not what the ranks gave");
  };
  require(work.rank() == rank && work.rank_count() == ranks);
  std::int64_t sums[] = {rank, 1};
  double most[] = {0.5 * rank, -1.0 * rank};
  work.sum(sums), work.max(most);
  require(sums[0] == ranks * (ranks - 1) / 2 && sums[1] == ranks);
  require(most[0] == 0.5 * (ranks - 1) && most[1] == 0);
  const std::vector<Bytes> all = work.all_gather([&](MessageWriter& writer) {
    if (rank != 1) writer.put(10 + rank);
  });
  require(all.size() == static_cast<std::size_t>(ranks));
  for (int from = 0; from < ranks; ++from)
    require(from == 1 ? all[1].empty() : MessageReader(all[static_cast<std::size_t>(from)]).get<int>() == 10 + from);
  const std::vector<Bytes> given = work.exchange([&](std::span<MessageWriter> to) {
    for (int r = 0; r < ranks; ++r)
      if (r != rank) to[static_cast<std::size_t>(r)].put(100 * rank + r);
  });
  require(given.size() == static_cast<std::size_t>(ranks));
  for (int from = 0; from < ranks; ++from) {
    const Bytes& bytes = given[static_cast<std::size_t>(from)];
    require(from == rank ? bytes.empty() : MessageReader(bytes).get<int>() == 100 * from + rank);
  }
}

}  // namespace

TEST_CASE("ranks tell each other what they have of their own") {
  const auto communicator = make_communicator();
  const SharedWork work(1, {}, communicator.get());
  work.together([&] { check_own(work, communicator->rank(), communicator->rank_count()); });
  const TaskRunner runner(1);
  check_own(runner, 0, 1);
  for (const int ranks : {1, 2, 3, 20}) {
    on_simulated_ranks(ranks, [&](Communicator& simulated) {
      const SharedWork shared(1, {}, &simulated);
      shared.together([&] { check_own(shared, simulated.rank(), ranks); });
    });
  }
}

TEST_CASE("ranks sort what they have together", "[ranks]") {
  const int ranks = GENERATE(1, 2, 7);
  const int kind = GENERATE(0, 1, 2);  // many everywhere, most on one rank, fewer than ranks
  constexpr std::uint64_t kMany = 20000;
  const auto count_of = [&](int rank) -> std::uint64_t {
    return kind == 0 ? kMany : kind == 1 ? (rank == 1 ? kMany : 3) : (rank % 3 == 0 ? 1 : 0);
  };
  std::vector<std::vector<std::uint64_t>> pieces(static_cast<std::size_t>(ranks));
  std::vector<std::uint64_t> expected;
  const auto value_of = [](int rank, std::uint64_t i) {
    return (i * 0x9e3779b97f4a7c15u ^ static_cast<std::uint64_t>(rank) << 7) * 64 + static_cast<std::uint64_t>(rank);
  };
  for (int rank = 0; rank < ranks; ++rank)
    for (std::uint64_t i = 0; i < count_of(rank); ++i) expected.push_back(value_of(rank, i));
  std::ranges::sort(expected);
  REQUIRE(std::ranges::adjacent_find(expected) == expected.end());
  on_simulated_ranks(ranks, [&](Communicator& communicator) {
    const SharedWork work(1, {}, &communicator);
    std::vector<std::uint64_t> own;
    for (std::uint64_t i = 0; i < count_of(work.rank()); ++i) own.push_back(value_of(work.rank(), i));
    work.together([&] { pieces[static_cast<std::size_t>(work.rank())] = sort_on_ranks(own, work); });
  });
  CHECK(joined(pieces) == expected);
  if (kind != 0) return;
  const auto least = std::ranges::min_element(pieces, {}, &std::vector<std::uint64_t>::size);
  CHECK(least->size() > kMany / 2);
}

TEST_CASE("what fails on one rank fails on all, with entities and place, wherever it happens") {
  const auto communicator = make_communicator();
  const SharedWork work(2, {}, communicator.get());
  for (int failing = 0; failing < communicator->rank_count(); ++failing) {
    const bool here = failing == communicator->rank();
    CAPTURE(failing);
    const auto fail = [&] {
      if (here) throw Error(trouble(failing));
    };
    check_trouble(outcome(work, fail), failing);
    check_trouble(outcome(work, [&] { run_loop(work), fail(), run_loop(work); }), failing);
    check_trouble(outcome(work, [&] { run_loop(work), run_loop(work), fail(); }), failing);
    check_trouble(outcome(work, [&] { run_loop(work, [&](std::size_t) { fail(); }), run_loop(work); }), failing);
    check_trouble(outcome(work, [&] { run_loop(work), fail(), work.together([&] { run_loop(work); }); }), failing);
    check_trouble(outcome(work, [&] { work.together([&] { run_loop(work), fail(), run_loop(work); }); }), failing);
    check_trouble(outcome(work, [&] { work.together([&] { run_loop(work); }), fail(), run_loop(work); }), failing);
    check_trouble(outcome(work, [&] { work.together([&] { run_loop(work, [&](std::size_t) { fail(); }); }); }),
                  failing);
    std::int64_t sum[] = {1};
    const auto fail_writing = [&](MessageWriter&) { fail(); };
    check_trouble(outcome(work, [&] { work.each(fail), run_loop(work); }), failing);
    check_trouble(outcome(work, [&] { fail(), work.sum(sum); }), failing);
    check_trouble(outcome(work, [&] { work.sum(sum), fail(), work.each([] {}); }), failing);
    check_trouble(outcome(work, [&] { work.all_gather(fail_writing), work.sum(sum); }), failing);
    check_trouble(outcome(work, [&] { work.exchange([&](std::span<MessageWriter> to) { fail_writing(to[0]); }); }),
                  failing);
    const auto fail_at = [&](bool put, bool take) {
      const std::vector<double> amounts(50, 1.0);
      return outcome(work, [&] {
        work.for_each(amounts, {[](std::size_t) {}, [&](std::size_t, MessageWriter&) { put ? fail() : void(); },
                                [&](std::size_t, MessageReader&) { take ? fail() : void(); }});
      });
    };
    if (communicator->rank_count() > 1) {
      check_trouble(fail_at(true, false), failing);
      check_trouble(fail_at(false, true), failing);
    }
    const auto exhausted = outcome(work, [&] {
      run_loop(work);
      if (here) throw std::bad_alloc();
      run_loop(work);
    });
    REQUIRE(exhausted);
    CHECK(exhausted->code == ErrorCode::OutOfMemory);
    CHECK_FALSE(outcome(work, [&] { run_loop(work); }));
  }
}

TEST_CASE("whatever a rank throws, wherever, is the same Error on all of them") {
  const std::vector<std::pair<std::function<void()>, std::string>> throws{
      {[] { throw Error(ErrorCode::Internal, "as it is"); }, "as it is"},
      {[] { throw std::length_error("too long"); }, "unexpected error: too long"},
      {[] { throw std::runtime_error("odd"); }, "unexpected error: odd"},
      {[] { throw 7; }, "unexpected error of an unknown type"},
      {[] { throw std::string("text"); }, "unexpected error of an unknown type"}};
  const auto check = [&](Communicator& communicator) {
    const SharedWork work(2, {}, &communicator);
    for (int failing = 0; failing < communicator.rank_count(); ++failing)
      for (const auto& thrown : throws) {
        const auto fail = [&] {
          if (communicator.rank() == failing) thrown.first();
        };
        const auto require = [&](const std::function<void()>& body) {
          const auto told = outcome(work, body);
          if (!told || told->code != ErrorCode::Internal || told->message != thrown.second)
            throw Error(ErrorCode::InvalidArgument, "another outcome than " + thrown.second);
        };
        std::int64_t sum[] = {1};
        require(fail);
        require([&] { run_loop(work, [&](std::size_t) { fail(); }), run_loop(work); });
        require([&] { run_loop(work), fail(), run_loop(work); });
        require([&] { fail(), work.ranks().sum(sum); });
        require([&] { work.ranks().sum(sum), fail(), work.ranks().all_gather({}); });
        require([&] { fail(), run_on_all(work.ranks(), [] {}); });
        require([&] { run_on_all(work.ranks(), fail), run_loop(work); });
        require([&] { run_on_first(work.ranks(), [] {}), fail(), share_number(work.ranks(), 3); });
        require([&] { fail(), exchange(work.ranks(), [](std::span<MessageWriter> to) { to[0].put(1); }); });
        require([&] { exchange(work.ranks(), [&](std::span<MessageWriter>) { fail(); }), run_loop(work); });
        require([&] {
          gather(
              work.ranks(), [](MessageWriter&) {}, [&](MessageReader&) { fail(); }),
              run_loop(work);
        });
        require([&] { fail(), work.together([&] { run_loop(work); }); });
        require([&] { SharedWork(1, {}, &work.ranks()).together([&] { run_loop(work), fail(), run_loop(work); }); });
      }
  };
  check(*make_communicator());
  for (const int ranks : {1, 2, 5}) on_simulated_ranks(ranks, check);
}

TEST_CASE("a rank that throws between schedules, or in one, ends the others' schedules") {
  const auto communicator = make_communicator();
  const std::size_t count = 7;
  const SharedWork work(2, {}, communicator.get());
  for (int failing = 0; failing < communicator->rank_count(); ++failing) {
    const auto fail = [&] {
      if (communicator->rank() == failing) throw std::length_error("too long");
    };
    const auto run = [&](const std::function<void()>& body) {
      PerPart<std::vector<PartId>> receivers(count, work.ranks().parts_of_rank(count));
      for (const PartId part : receivers.local()) receivers.at(part) = {PartId((part.value + 1) % count)};
      const Links links = directed_links(work.ranks(), receivers);
      const std::vector<Step> steps{{"send", [&](PartTask&) { body(); }, links, {}},
                                    {"take", [](PartTask&) {}, {}, {}}};
      Schedule(work.ranks(), work.runner(), count).run(steps);
    };
    const auto told = outcome(work, [&] { run([] {}), fail(), run([] {}); });
    REQUIRE(told);
    CHECK(told->message == "unexpected error: too long");
    if (!communicator->parts_of_rank(count).empty())
      CHECK(outcome(work, [&] { run(fail); })->code == ErrorCode::Internal);
    CHECK_FALSE(outcome(work, [&] { run([] {}); }));
  }
}

TEST_CASE("a failure that all ranks get over is forgotten") {
  const auto communicator = make_communicator();
  const SharedWork work(1, {}, communicator.get());
  const int last = communicator->rank_count() - 1;
  const bool here = communicator->rank() == last;
  const auto told = outcome(work, [&] {
    const auto first = outcome(work, [&] {
      run_loop(work);
      if (here) throw Error(ErrorCode::OutOfMemory, "too much");
      run_loop(work);
    });
    CHECK((first && first->code == ErrorCode::OutOfMemory));
    run_loop(work);
    if (here) throw Error(trouble(last));
    run_loop(work);
  });
  check_trouble(told, last);
}

TEST_CASE("the host of one rank stops all of them, in the middle of what they do") {
  const auto communicator = make_communicator();
  for (int stopping = 0; stopping < communicator->rank_count(); ++stopping) {
    CAPTURE(stopping);
    Host host;
    if (communicator->rank() == stopping) host.wants_stop = [] { return true; };
    const SharedWork work(2, host, communicator.get());
    const auto told = outcome(work, [&] {
      run_loop(work, [&](std::size_t) {
        while (!work.runner().cancelled()) std::this_thread::yield();
        work.runner().check_cancelled();
      });
    });
    REQUIRE(told);
    CHECK(told->code == ErrorCode::Cancelled);
    CHECK(work.runner().cancelled() == (communicator->rank() == stopping));
  }
}

TEST_CASE("ranks that are stopped because another one fails tell of that failure") {
  const auto communicator = make_communicator();
  if (communicator->rank_count() == 1) return;
  for (int failing = 0; failing < communicator->rank_count(); ++failing) {
    CAPTURE(failing);
    const bool here = communicator->rank() == failing;
    const SharedWork work(1, {}, communicator.get());
    check_trouble(outcome(work,
                          [&] {
                            run_loop(work, [&](std::size_t) {
                              if (here) throw Error(trouble(failing));
                              while (!work.runner().cancelled()) std::this_thread::yield();
                              work.runner().check_cancelled();
                            });
                          }),
                  failing);
  }
}
