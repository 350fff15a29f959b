#include "threading/runtime/pausable.hpp"

#include <catch2/catch.hpp>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tetloom/tasks.hpp"

using namespace tetloom;

TEST_CASE("work pauses and goes on where it was") {
  std::string log;
  Pausable work([&] {
    log += "a";
    Pausable::pause();
    for (int i = 0; i < 2; ++i) Pausable::pause(), log += "b";
  });
  CHECK(log.empty());  // it has not begun
  CHECK_FALSE(work.resume());
  CHECK(log == "a");
  CHECK_FALSE(work.resume());
  CHECK_FALSE(work.resume());
  CHECK(log == "ab");
  CHECK(work.resume());
  CHECK(log == "abb");
  CHECK(work.resume());  // nothing more to do
  CHECK(log == "abb");
}

TEST_CASE("only such work is told that it is") {
  CHECK_FALSE(Pausable::is_here());
  bool inside = false;
  CHECK(Pausable([&] { inside = Pausable::is_here(); }).resume());
  CHECK(inside);
  CHECK_FALSE(Pausable::is_here());
}

TEST_CASE("what work throws reaches who resumes it, once") {
  Pausable work([] {
    Pausable::pause();
    throw std::runtime_error("after the pause");
  });
  CHECK_FALSE(work.resume());
  CHECK_THROWS_WITH(work.resume(), "after the pause");
  CHECK(work.resume());
}

TEST_CASE("work that is left is unwound, and does not go on") {
  struct Noted {
    bool& flag;
    ~Noted() { flag = true; }
  };
  bool unwound = false, went_on = false;
  {
    Pausable work([&] {
      const Noted noted{unwound};
      Pausable::pause();
      went_on = true;
    });
    CHECK_FALSE(work.resume());
    CHECK_FALSE(unwound);
  }
  CHECK(unwound);
  CHECK_FALSE(went_on);
  Pausable([&] { went_on = true; });  // left before it began
  CHECK_FALSE(went_on);
}

TEST_CASE("threads of a loop resume work of their own") {
  const TaskRunner runner(4);
  std::vector<std::unique_ptr<Pausable>> all(50);
  std::atomic<int> sum = 0, attempts = 0;
  const auto go_on = [&] {
    runner.for_each(all.size(), [&](std::size_t i) {
      if (!all[i])
        all[i] = std::make_unique<Pausable>([&sum, i] {
          for (std::size_t k = 0; k < i % 3; ++k) Pausable::pause();
          sum += static_cast<int>(i);
        });
      all[i]->resume();
      ++attempts;
    });
  };
  for (int round = 0; round < 3; ++round) go_on();
  CHECK(sum == 50 * 49 / 2);
  CHECK(attempts == 150);
}

TEST_CASE("processor time counts for who resumes") {
  const double before = Pausable::processor_seconds();
  double inside = 0;
  Pausable work([&] {
    while (Pausable::processor_seconds() < 0.02) continue;
    Pausable::pause();
    inside = Pausable::processor_seconds();
  });
  work.resume();
  const double after = Pausable::processor_seconds();
  CHECK(after - before >= 0.02);
  work.resume();
  CHECK(Pausable::processor_seconds() - before >= inside);
}
