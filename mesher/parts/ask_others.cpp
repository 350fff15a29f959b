#include "mesher/parts/ask_others.hpp"

#include <algorithm>

#include "mesher/parts/shell_steps.hpp"
#include "threading/agreement.hpp"

namespace tetloom::parts {

namespace {

constexpr std::size_t kMostRounds = 8;

void ask(const AllParts& parts, PartId part, std::vector<Message>& questions) {
  const Decomposition& decomposition = parts.input.decomposition;
  std::vector<std::vector<Doubt>> part_to_doubts(decomposition.part_count());
  for (const Doubt& doubt : parts.states.at(part).doubts) {
    const Vec3 reach{doubt.radius, doubt.radius, doubt.radius};
    decomposition.for_each_in({doubt.center - reach, doubt.center + reach}, [&](PartId other) {
      if (other != part) part_to_doubts[other.value].push_back(doubt);
    });
  }
  for (std::size_t other = 0; other < part_to_doubts.size(); ++other) {
    if (part_to_doubts[other].empty()) continue;
    MessageWriter writer;
    writer.put_array<Doubt>(part_to_doubts[other]);
    questions.push_back({part, PartId(other), 0, writer.take()});
  }
}

std::vector<Message> answer(const AllParts& parts, const std::vector<Message>& questions) {
  std::vector<Message> answers(questions.size());
  const TraceSpan span(parts.trace, "answer", parts.runner.threads(), questions.size());
  parts.runner.for_each(questions.size(), [&](std::size_t i) {
    const Message& question = questions[i];
    const auto doubts = MessageReader(question.bytes).get_view<Doubt>();
    MessageWriter writer;
    writer.put_array<ShellPoint>(find_points_in(parts.input, parts.states.at(question.to), question.to, doubts));
    answers[i] = {question.to, question.from, 0, writer.take()};
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
    parts.states.at(part).doubts.clear();
    if (!part_to_points[part.value].empty()) told.push_back(part);
  }
  std::vector<char> learnt(told.size(), 0);
  run_on_all(parts.communicator, [&] {
    const TraceSpan span(parts.trace, "take answers", parts.runner.threads(), told.size());
    parts.runner.for_each(told.size(), [&](std::size_t i) {
      PartState& state = parts.states.at(told[i]);
      if (!add_shell_points(parts.input, state, part_to_points[told[i].value])) return;
      make_shell(parts.input, state, told[i], parts.runner);
      learnt[i] = 1;
    });
  });
  return parts.sum(static_cast<std::uint64_t>(std::count(learnt.begin(), learnt.end(), 1))) > 0;
}

}  // namespace

Asked ask_others(const AllParts& parts) {
  Asked asked;
  std::uint64_t tets = 0;
  for (const PartId part : parts.states.local()) tets += parts.states.at(part).doubts.size();
  asked.tets = parts.sum(tets);
  while (asked.rounds < kMostRounds && !parts.any_fault()) {
    std::vector<Message> questions;
    run_on_all(parts.communicator, [&] {
      for (const PartId part : parts.states.local()) ask(parts, part, questions);
    });
    if (parts.sum(questions.size()) == 0) return asked;
    ++asked.rounds;
    questions = parts.exchange(std::move(questions));
    std::vector<Message> answers;
    run_on_all(parts.communicator, [&] { answers = answer(parts, questions); });
    if (!take_answers(parts, parts.exchange(std::move(answers)))) return asked;
  }
  return asked;
}

}  // namespace tetloom::parts
