#include "mesher/parts/ask_others.hpp"

#include <algorithm>
#include <limits>

#include "core/base/stopwatch.hpp"
#include "mesher/parts/own_points.hpp"
#include "mesher/parts/shell_steps.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::parts {

namespace {

// Of a ball that holds many points a few nearest ones tell enough: the tets made with them have smaller balls. Should
// that not come to an end soon, all are told.
constexpr std::size_t kMostRounds = 8, kRoundsOfNearest = 5;
constexpr std::size_t kNearest = 8;

void ask(const AllParts& parts, PartId part, std::vector<Message>& questions) {
  const Decomposition& decomposition = parts.input.decomposition;
  std::vector<std::vector<OpenBall>> part_to_balls(decomposition.part_count());
  for (const OpenBall& ball : parts.states.at(part).shell.open_balls) {
    const Vec3 reach{ball.radius, ball.radius, ball.radius};
    decomposition.for_each_in({ball.center - reach, ball.center + reach}, [&](PartId other) {
      if (other != part) part_to_balls[other.value].push_back(ball);
    });
  }
  for (std::size_t other = 0; other < part_to_balls.size(); ++other) {
    if (part_to_balls[other].empty()) continue;
    MessageWriter writer;
    writer.put_array<OpenBall>(part_to_balls[other]);
    questions.push_back({part, PartId(other), 0, writer.take()});
  }
}

std::vector<Message> answer(const AllParts& parts, const std::vector<Message>& questions, std::size_t most_per_ball) {
  std::vector<Message> answers(questions.size());
  std::vector<std::vector<std::size_t>> part_to_questions(parts.states.part_count());
  for (std::size_t i = 0; i < questions.size(); ++i) part_to_questions[questions[i].to.value].push_back(i);
  const auto& local = parts.states.local();
  const TraceSpan span(parts.trace, "answer", parts.runner.threads(), local.size());
  parts.runner.for_each(local.size(), [&](std::size_t p) {
    const std::vector<std::size_t>& asked = part_to_questions[local[p].value];
    if (asked.empty()) return;
    const OwnPoints points = find_own_points(parts.input, parts.states.at(local[p]).shell, local[p]);
    for (const std::size_t i : asked) {
      const auto open_balls = MessageReader(questions[i].bytes).get_view<OpenBall>();
      MessageWriter writer;
      writer.put_array<ShellPoint>(points.find_in(open_balls, most_per_ball));
      answers[i] = {questions[i].to, questions[i].from, 0, writer.take()};
    }
  });
  return answers;
}

// Whether any part has learnt something new, and has made its shell anew then.
bool take_answers(const AllParts& parts, const std::vector<Message>& answers) {
  std::vector<std::vector<ShellPoint>> part_to_points(parts.states.part_count());
  for (const Message& message : answers) {
    const auto points = MessageReader(message.bytes).get_view<ShellPoint>();
    auto& list = part_to_points[message.to.value];
    list.insert(list.end(), points.begin(), points.end());
  }
  std::vector<PartId> told;  // few: most have asked nobody
  for (const PartId part : parts.states.local()) {
    parts.states.at(part).shell.open_balls.clear();
    if (!part_to_points[part.value].empty()) told.push_back(part);
  }
  std::vector<char> learnt(told.size(), 0);
  run_on_all(parts.communicator, [&] {
    const TraceSpan span(parts.trace, "take answers", parts.runner.threads(), told.size());
    parts.runner.for_each(told.size(), [&](std::size_t i) {
      PartState& state = parts.states.at(told[i]);
      if (!add_shell_points(parts.input, state.shell, part_to_points[told[i].value])) return;
      Stopwatch watch;
      state.fault = make_shell(parts.input, state.shell, told[i], parts.runner);
      state.figures.seconds.delaunay += watch.lap();
      learnt[i] = 1;
    });
  });
  return sum_over_ranks(parts.communicator, static_cast<std::uint64_t>(std::ranges::count(learnt, 1))) > 0;
}

}  // namespace

Asked ask_others(const AllParts& parts) {
  Asked asked;
  std::uint64_t tets = 0;
  for (const PartId part : parts.states.local()) tets += parts.states.at(part).shell.open_balls.size();
  asked.tets = sum_over_ranks(parts.communicator, tets);
  while (asked.rounds < kMostRounds && !parts.any_fault()) {
    std::vector<Message> questions;
    run_on_all(parts.communicator, [&] {
      for (const PartId part : parts.states.local()) ask(parts, part, questions);
    });
    if (sum_over_ranks(parts.communicator, questions.size()) == 0) return asked;
    ++asked.rounds;
    questions = parts.exchange([&] { return std::move(questions); });
    const std::size_t most = asked.rounds <= kRoundsOfNearest ? kNearest : std::numeric_limits<std::size_t>::max();
    if (!take_answers(parts, parts.exchange([&] { return answer(parts, questions, most); }))) return asked;
  }
  return asked;
}

}  // namespace tetloom::parts
