#pragma once
// A program for parts whose every value depends on all messages and their order, and a serial oracle for it.
#include <cstdint>
#include <deque>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tetloom/tasks.hpp"

namespace tetloom::test {

/// The receivers of each part, for the messages of one step.
using Graph = std::vector<std::vector<PartId>>;

inline Graph graph_of(const std::vector<std::set<std::size_t>>& sets) {
  Graph graph(sets.size());
  for (std::size_t part = 0; part < sets.size(); ++part)
    for (const std::size_t to : sets[part]) graph[part].push_back(PartId(to));
  return graph;
}

inline Graph ring(std::size_t count) {
  std::vector<std::set<std::size_t>> sets(count);
  for (std::size_t part = 0; part < count; ++part)
    if (count > 1) sets[part] = {(part + 1) % count, (part + count - 1) % count};
  return graph_of(sets);
}

inline Graph grid(std::size_t width, std::size_t height) {
  std::vector<std::set<std::size_t>> sets(width * height);
  const auto join = [&](std::size_t a, std::size_t b) {
    sets[a].insert(b);
    sets[b].insert(a);
  };
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      if (x + 1 < width) join(y * width + x, y * width + x + 1);
      if (y + 1 < height) join(y * width + x, (y + 1) * width + x);
    }
  return graph_of(sets);
}

/// A part may be its own receiver, hear nobody or speak to nobody.
inline Graph random_directed(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::set<std::size_t>> sets(count);
  for (auto& set : sets)
    for (std::size_t i = random() % 5; i > 0; --i) set.insert(random() % count);
  return graph_of(sets);
}

inline std::uint64_t mixed(std::uint64_t a, std::uint64_t b) {
  const std::uint64_t hash = (a ^ (b + 0x9e3779b97f4a7c15u + (a << 6) + (a >> 2))) * 0xff51afd7ed558ccdu;
  return hash ^ (hash >> 32);
}

/// What a part sends: nothing for some pairs, so that empty messages occur.
inline std::vector<std::uint64_t> words_for(std::uint64_t value, PartId to) {
  const std::uint64_t hash = mixed(value, to.value);
  return std::vector<std::uint64_t>(hash % 4, hash);
}

using Values = std::vector<std::uint64_t>;

/// graphs[k]: where the messages of step k go. The last step sends nothing.
inline Values serial_result(std::size_t count, const std::vector<Graph>& graphs) {
  Values values(count);
  for (std::size_t part = 0; part < count; ++part) values[part] = part + 1;
  std::vector<std::vector<std::pair<std::size_t, std::vector<std::uint64_t>>>> inboxes(count);
  for (std::size_t step = 0; step <= graphs.size(); ++step) {
    auto heard = std::exchange(inboxes, decltype(inboxes)(count));
    for (std::size_t part = 0; part < count; ++part) {
      for (const auto& [from, words] : heard[part])
        for (const std::uint64_t word : words) values[part] = mixed(mixed(values[part], from), word);
      values[part] = mixed(values[part], step);
      if (step == graphs.size()) continue;
      for (const PartId to : graphs[step][part])
        if (auto words = words_for(values[part], to); !words.empty()) inboxes[to.value].push_back({part, words});
    }
  }
  return values;
}

/// Called in every step of every part, to disturb it.
using Hook = std::function<void(std::uint32_t step, PartTask&)>;

/// The same by parts. Lives as long as its steps are run.
class PartProgram {
 public:
  PartProgram(Communicator& communicator, std::size_t count, const std::vector<Graph>& graphs, Hook hook = {})
      : communicator_(communicator),
        graphs_(graphs),
        hook_(std::move(hook)),
        values_(count, communicator.parts_of_rank(count)) {
    for (const PartId part : values_.local()) values_.at(part) = part.value + 1;
    for (const Graph& graph : graphs_) {
      receivers_.emplace_back(count, values_.local());
      for (const PartId part : values_.local()) receivers_.back().at(part) = graph[part.value];
    }
    for (std::uint32_t step = 0; step <= graphs_.size(); ++step)
      steps_.push_back({"step " + std::to_string(step), [this, step](PartTask& task) { body(step, task); },
                        step < graphs_.size() ? directed_links(communicator, receivers_[step]) : Links{},
                        [step](PartId part) { return static_cast<double>((part.value * 7 + step) % 5); }});
  }
  PartProgram(const PartProgram&) = delete;
  PartProgram& operator=(const PartProgram&) = delete;

  std::span<const Step> steps() const { return steps_; }
  std::uint64_t& value_of(PartId part) { return values_.at(part); }

  /// The values of all parts, on all ranks.
  Values gathered() {
    MessageWriter writer;
    for (const PartId part : values_.local()) writer.put(values_.at(part));
    Values all;
    for (const Bytes& bytes : communicator_.all_gather(writer.take()))
      for (MessageReader reader(bytes); !reader.at_end();) all.push_back(reader.get<std::uint64_t>());
    return all;
  }

 private:
  void body(std::uint32_t step, PartTask& task) {
    std::uint64_t& value = values_[task];
    for (Message& message : task.inbox())
      for (const std::uint64_t word : MessageReader(message.bytes).get_array<std::uint64_t>())
        value = mixed(mixed(value, message.from.value), word);
    value = mixed(value, step);
    if (hook_) hook_(step, task);
    if (step < graphs_.size()) send(step, task, value);
  }
  void send(std::uint32_t step, PartTask& task, std::uint64_t value) {
    for (const PartId to : graphs_[step][task.part().value]) {
      const auto words = words_for(value, to);
      MessageWriter writer;
      if (!words.empty()) writer.put_array(std::span(words));
      if (!writer.empty() || to.value % 2 == 0) task.send(to, writer.take());
    }
  }

  Communicator& communicator_;
  std::vector<Graph> graphs_;
  Hook hook_;
  PerPart<std::uint64_t> values_;
  std::deque<PerPart<std::vector<PartId>>> receivers_;  // links refer to them
  std::vector<Step> steps_;
};

}  // namespace tetloom::test
