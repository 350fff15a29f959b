#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <exception>
#include <thread>

#include "tests/support/error_of.hpp"
#include "tests/threading/communicators.hpp"
#include "tests/threading/part_program.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

using PartsOf = std::vector<std::vector<PartId>>;

Step plain_step(std::function<void(PartTask&)> body, Links links = {}) {
  return {"plain", std::move(body), std::move(links), {}};
}

Links links_of(const Graph& graph) {
  return neighbour_links([&graph](PartId part) { return std::span<const PartId>(graph[part.value]); });
}

}  // namespace

TEST_CASE("a pipeline gives the serial result on rings, grids and random graphs, with any threads and ranks") {
  const auto communicator = make_communicator();
  std::vector<std::pair<std::size_t, std::vector<Graph>>> programs{{1, {ring(1), ring(1)}},
                                                                   {2, {ring(2), ring(2), ring(2)}},
                                                                   {7, {ring(7), ring(7), ring(7), ring(7)}},
                                                                   {30, {grid(5, 6), grid(6, 5), grid(30, 1)}}};
  for (std::uint32_t seed = 0; seed < 8; ++seed) {
    const std::size_t count = 3 + 17 * seed;
    programs.push_back({count, {random_directed(count, seed), ring(count), random_directed(count, seed + 100)}});
  }
  for (const int threads : {1, 2, 4})
    for (const auto& [count, graphs] : programs) {
      CAPTURE(threads, count);
      const TaskRunner runner(threads);
      const auto on_threads = make_thread_communicator();
      PartProgram program(*communicator, count, graphs), same(*on_threads, count, graphs);
      Schedule(*communicator, runner, count).run(program.steps());
      Schedule(*on_threads, runner, count).run(same.steps());
      const Values values = program.gathered();
      CHECK(values == serial_result(count, graphs));
      CHECK(values == same.gathered());
    }
}

TEST_CASE("a part waits for its neighbours only") {
  const auto communicator = make_communicator();
  const std::size_t count = 12;
  const Graph line = grid(count, 1);
  std::atomic<bool> far_done{false};  // raised by the last part's first step, read by the first part's later steps
  // The last part's first step ends only after a part six places away on the same rank has finished its fifth step; a
  // barrier between steps would never let that happen.
  const auto local = communicator->parts_of_rank(count);
  if (communicator->rank_count() > 1) return;
  std::atomic<int> first_part_steps{0};  // counted by the first part, awaited by the last one
  const auto body = [&](PartTask& task) {
    if (task.part() == local.front()) ++first_part_steps;
    if (task.part() != local.back() || far_done.exchange(true)) return;
    while (first_part_steps < 5) std::this_thread::yield();
  };
  const std::vector<Step> steps(8, plain_step(body, links_of(line)));
  const TaskRunner runner(2);
  Schedule(*communicator, runner, count).run(steps);
  CHECK(first_part_steps == 8);
}

TEST_CASE("an exception at any step and part reaches the caller on all ranks, and the next run works") {
  const auto communicator = make_communicator();
  const std::size_t count = 5;
  const std::vector<Graph> graphs{ring(count), random_directed(count, 3)};
  const TaskRunner runner(2);
  for (std::uint32_t step = 0; step < 3; ++step)
    for (std::size_t part = 0; part < count; ++part) {
      CAPTURE(step, part);
      PartProgram program(*communicator, count, graphs, [&](std::uint32_t at, PartTask& task) {
        if (at == step && task.part() == PartId(part)) throw Error(ErrorCode::FaceFailed, "planted");
      });
      Schedule schedule(*communicator, runner, count);
      const Diagnostic failure = error_of([&] { schedule.run(program.steps()); });
      CHECK(failure.code == ErrorCode::FaceFailed);
      CHECK(failure.message == "planted");
      PartProgram next(*communicator, count, graphs);
      schedule.run(next.steps());
      CHECK(next.gathered() == serial_result(count, graphs));
    }
}

TEST_CASE("whatever a step throws is an Error on all ranks, and the next run works") {
  const auto communicator = make_communicator();
  const std::size_t count = 5;
  const std::vector<Graph> graphs{ring(count)};
  const TaskRunner runner(2);
  const std::vector<std::pair<std::function<void()>, ErrorCode>> throws{
      {[] { throw std::length_error("too long"); }, ErrorCode::Internal},
      {[] { throw std::bad_alloc(); }, ErrorCode::OutOfMemory},
      {[] { throw 7; }, ErrorCode::Internal}};
  for (const auto& [fail, code] : throws)
    for (std::size_t part = 0; part < count; ++part) {
      CAPTURE(part, code);
      PartProgram program(*communicator, count, graphs, [&, fail = fail](std::uint32_t, PartTask& task) {
        if (task.part() == PartId(part)) fail();
      });
      Schedule schedule(*communicator, runner, count);
      const Diagnostic failure = error_of([&] { schedule.run(program.steps()); });
      CHECK(failure.code == code);
      CHECK_FALSE(failure.message.empty());
      PartProgram next(*communicator, count, graphs);
      schedule.run(next.steps());
      CHECK(next.gathered() == serial_result(count, graphs));
    }
}

TEST_CASE("of several exceptions the one of the earliest step and lowest part is reported") {
  const auto communicator = make_communicator();
  const TaskRunner runner(1);
  Schedule schedule(*communicator, runner, 8);
  if (schedule.local_parts().empty()) return;
  // Two bodies wait for each other and then both throw, so that both errors are there.
  const TaskRunner two(2);
  const auto local = make_thread_communicator();
  std::atomic<int> inside{0};  // counts the two bodies, each waits for the other
  const auto body = [&](PartTask& task) {
    ++inside;
    while (inside < 2) std::this_thread::yield();
    throw Error(ErrorCode::FaceFailed, std::to_string(task.part().value));
  };
  const std::vector<Step> steps{plain_step(body)};
  CHECK(error_of([&] { Schedule(*local, two, 2).run(steps); }).message == "0");
}

TEST_CASE("the host's cancel ends a run in the middle, unless it is uninterruptible") {
  const auto communicator = make_communicator();
  const std::size_t count = 9;
  const std::vector<Graph> graphs(20, ring(count));
  for (const bool uninterruptible : {false, true}) {
    CAPTURE(uninterruptible);
    CancelToken token;
    const TaskRunner runner(2, {{}, &token});
    PartProgram program(*communicator, count, graphs, [&](std::uint32_t step, PartTask& task) {
      if (step == 5) token.cancel();
      task.check_cancelled();
      task.runner().for_each(3, [](std::size_t) {});
    });
    Schedule schedule(*communicator, runner, count);
    if (uninterruptible) {
      schedule.run(program.steps(), true);
      CHECK(program.gathered() == serial_result(count, graphs));
    } else {
      CHECK(error_of([&] { schedule.run(program.steps()); }).code == ErrorCode::Cancelled);
    }
    if (uninterruptible) CHECK(runner.cancelled() == !schedule.local_parts().empty());
  }
}

TEST_CASE("empty messages are heard but not handed over") {
  const auto communicator = make_communicator();
  const std::size_t count = 6;
  const Graph graph = ring(count);
  std::atomic<std::size_t> bad{0};  // counted by bodies, read after the run
  const std::vector<Step> steps{plain_step(
                                    [&](PartTask& task) {
                                      for (const PartId to : graph[task.part().value]) {
                                        if (task.part().value % 3 == 0) task.send(to, Bytes(1));
                                        if (task.part().value % 3 == 1) task.send(to, {});
                                      }
                                    },
                                    links_of(graph)),
                                plain_step([&](PartTask& task) {
                                  for (const Message& message : task.inbox())
                                    if (message.from.value % 3 != 0 || message.bytes.size() != 1) ++bad;
                                  if (task.inbox().size() != (task.part().value % 3 == 0 ? 0u : 1u)) ++bad;
                                })};
  const TaskRunner runner(2);
  Schedule(*communicator, runner, count).run(steps);
  CHECK(bad == 0);
}

TEST_CASE("a huge message arrives whole") {
  const auto communicator = make_communicator();
  const std::size_t size = (std::size_t{80} << 20) + 3;  // more than one piece on MPI
  const Graph graph = graph_of({{1}, {0}});
  std::atomic<std::size_t> good{0};  // counted by bodies, read after the run
  const auto byte_at = [](std::size_t i) { return static_cast<std::byte>((i * 2654435761u) >> 24); };
  const auto send = [&](PartTask& task) {
    if (task.part() == PartId(0)) return;
    Bytes bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = byte_at(i);
    task.send(PartId(0), std::move(bytes));
  };
  const auto check = [&](PartTask& task) {
    for (const Message& message : task.inbox()) {
      bool same = message.bytes.size() == size;
      for (std::size_t i = 0; same && i < size; ++i) same = message.bytes[i] == byte_at(i);
      good += same;
    }
  };
  const std::vector<Step> steps{plain_step(send, links_of(graph)), plain_step(check)};
  const TaskRunner runner(1);
  Schedule(*communicator, runner, 2).run(steps);
  CHECK(good == (communicator->rank() == 0 ? 1 : 0));
}

TEST_CASE("a message to a part that is no receiver, a second one and one in the last step are refused") {
  const auto communicator = make_thread_communicator();
  const Graph graph = ring(5);
  const TaskRunner runner(1);
  Schedule schedule(*communicator, runner, 5);
  const auto run = [&](std::function<void(PartTask&)> body, Links links) {
    const std::vector<Step> steps{plain_step(std::move(body), links), plain_step([](PartTask&) {}, links)};
    return error_of([&] { schedule.run(steps); }).code;
  };
  CHECK(run([](PartTask& task) { task.send(task.part(), Bytes(1)); }, links_of(graph)) == ErrorCode::Internal);
  CHECK(run([](PartTask& task) { task.send(PartId(0), Bytes(1)); }, {}) == ErrorCode::Internal);
  CHECK(run(
            [&](PartTask& task) {
              for (int i = 0; i < 2; ++i) task.send(graph[task.part().value][0], {});
            },
            links_of(graph)) == ErrorCode::Internal);
  const std::vector<Step> last{
      plain_step([&](PartTask& task) { task.send(graph[task.part().value][0], {}); }, links_of(graph))};
  CHECK(error_of([&] { schedule.run(last); }).code == ErrorCode::Internal);
}

TEST_CASE("links on which the two sides disagree are refused before any step") {
  const auto communicator = make_communicator();
  const Graph there = random_directed(12, 5), back = ring(12);
  const Links links{links_of(there).receivers, links_of(back).senders};
  int visits = 0;
  const std::vector<Step> steps(2, plain_step([&](PartTask&) { ++visits; }, links));
  const TaskRunner runner(1);
  CHECK(error_of([&] { Schedule(*communicator, runner, 12).run(steps); }).code == ErrorCode::Internal);
  CHECK(visits == 0);
}

TEST_CASE("on one thread the largest part starts first") {
  const auto communicator = make_thread_communicator();
  const std::vector<double> work{1, 5, 3, 5, 0};
  std::vector<std::uint32_t> order;
  Step step = plain_step([&](PartTask& task) { order.push_back(task.part().value); });
  step.work = [&](PartId part) { return work[part.value]; };
  const TaskRunner runner(1);
  Schedule(*communicator, runner, work.size()).run(std::span(&step, 1));
  CHECK(order == std::vector<std::uint32_t>{1, 3, 2, 0, 4});
}

TEST_CASE("a thread that waits for a loop inside a step begins no other step") {
  const auto communicator = make_communicator();
  const std::size_t count = 200;
  const std::vector<Graph> graphs(3, ring(count));
  const TaskRunner runner(3);
  std::atomic<int> bad{0};  // counted by bodies, read after the run
  static thread_local int depth = 0;
  PartProgram program(*communicator, count, graphs, [&](std::uint32_t, PartTask& task) {
    if (++depth > 1) ++bad;
    task.runner().for_each(3, [&](std::size_t) {
      if (inside_a_step() && !task.is_current()) ++bad;
      task.runner().for_each(3, [](std::size_t) { std::this_thread::yield(); });
    });
    if (!task.is_current()) ++bad;
    --depth;
  });
  Schedule(*communicator, runner, count).run(program.steps());
  CHECK(bad == 0);
  CHECK(program.gathered() == serial_result(count, graphs));
}

#ifndef NDEBUG
TEST_CASE("reaching for a part without the right handle is caught in debug builds") {
  const auto communicator = make_thread_communicator();
  const TaskRunner runner(2);
  Schedule schedule(*communicator, runner, 4);
  PerPart<int> values(4, schedule.local_parts());
  const auto code_of = [&](std::function<void(PartTask&)> body) {
    const std::vector<Step> steps{plain_step(std::move(body))};
    return error_of([&] { schedule.run(steps); }).code;
  };
  CHECK(code_of([&](PartTask& task) { values.at(task.part()) = 1; }) == ErrorCode::Internal);
  CHECK(code_of([&](PartTask& task) {
          std::exception_ptr thrown;
          std::thread other([&] {
            try {
              values[task] = 1;
            } catch (...) {
              thrown = std::current_exception();
            }
          });
          other.join();
          if (thrown) std::rethrow_exception(thrown);
        }) == ErrorCode::Internal);
  std::vector<Step> steps{plain_step([&](PartTask& task) { values[task] = 1; })};
  schedule.run(steps);
  CHECK(values.at(PartId(3)) == 1);
}
#endif

TEST_CASE("the cost of a large graph", "[.][cost]") {
  const auto communicator = make_communicator();
  const std::size_t width = 128, count = width * width, step_count = 6;
  const Graph graph = grid(width, width);
  std::size_t messages = 0;
  for (const auto& list : graph) messages += list.size() * (step_count - 1);
  for (const int loops : {0, 1, 2})
    for (const int threads : {1, 2}) {
      const TaskRunner runner(threads);
      const auto body = [&](PartTask& task) {
        if (loops > 0) task.runner().for_each(loops, [](std::size_t) {});
      };
      const std::vector<Step> steps(step_count, plain_step(body, links_of(graph)));
      Schedule schedule(*communicator, runner, count);
      const auto start = std::chrono::steady_clock::now();
      schedule.run(steps);
      const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - start;
      WARN("loops " << loops << ", threads " << threads << ": " << time.count() / 1e3 << " ms, "
                    << time.count() / static_cast<double>(count * step_count) << " us per node, "
                    << time.count() / static_cast<double>(messages) << " us per message if all were theirs");
    }
}
