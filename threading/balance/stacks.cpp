#include "threading/balance/stacks.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

#include "core/base/lists.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::balance_detail {
namespace {

constexpr double kMostStacks = 9007199254740992.0;  // 2^53: beyond it integers are no longer all doubles

std::uint64_t stack_of(double value) {
  const bool is_stack = value >= 1 && value <= kMostStacks && std::floor(value) == value;
  return is_stack ? static_cast<std::uint64_t>(value) : 0;
}

// By cell number; 0 for none.
std::vector<std::uint64_t> read_stacks(const PartMesh& part) {
  const auto field = std::ranges::find_if(
      part.cell_fields, [](const CellField& one) { return one.name == kStackField && one.components == 1; });
  std::vector<std::uint64_t> stacks;
  if (field == part.cell_fields.end()) return stacks;
  stacks.reserve(part.cell_count());
  for (const auto& values : field->values)
    for (const double value : values) stacks.push_back(stack_of(value));
  return stacks;
}

std::vector<std::uint64_t> distinct(const std::vector<std::uint64_t>& stacks) {
  std::vector<std::uint64_t> found;
  for (const std::uint64_t stack : stacks)
    if (stack != 0 && (found.empty() || found.back() != stack)) found.push_back(stack);
  sort_unique(found);
  return found;
}

// What one part has of a stack, and where it would send it.
struct Wish {
  std::uint64_t stack = 0;
  std::uint32_t target = 0, cells = 0;
};

// The targets of a part's stacks, those of one stack together.
std::vector<Wish> wishes_of(const StackItems& items, const Destinations& destinations) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> wishes;  // stack, target; once for each cell
  for (std::size_t cell = 0; cell < items.cell_to_item.size(); ++cell)
    if (items.cell_to_item[cell] >= items.first_stack())
      wishes.emplace_back(items.cell_to_item[cell] - items.first_stack(), destinations[cell]);
  std::ranges::sort(wishes);
  std::vector<Wish> counted;
  for (const auto& [index, target] : wishes) {
    const std::uint64_t stack = items.stacks[index];
    if (counted.empty() || counted.back().stack != stack || counted.back().target != target)
      counted.push_back({stack, target, 0});
    ++counted.back().cells;
  }
  return counted;
}

// Stacks are sorted out by the parts that their numbers name.
std::vector<Message> tell_homes(PartId self, std::size_t parts, std::span<const Wish> wishes) {
  std::vector<std::vector<Wish>> by_home(parts);
  for (const Wish& wish : wishes) by_home[wish.stack % parts].push_back(wish);
  std::vector<Message> messages;
  for (std::uint32_t home = 0; home < parts; ++home) {
    if (by_home[home].empty()) continue;
    MessageWriter writer;
    writer.put_array(std::span<const Wish>(by_home[home]));
    messages.push_back({self, PartId(home), 0, writer.take()});
  }
  return messages;
}

struct Heard {
  Wish wish;
  PartId from;
};

std::uint32_t most_wanted(std::span<const Heard> all) {
  std::vector<std::pair<std::uint32_t, std::uint64_t>> cells;  // of each target; ascending
  for (const Heard& one : all) {
    if (cells.empty() || cells.back().first != one.wish.target) cells.emplace_back(one.wish.target, 0);
    cells.back().second += one.wish.cells;
  }
  return std::ranges::max_element(cells, {}, [](const auto& target) { return target.second; })->first;
}

// To every part that wants a stack elsewhere than it goes.
std::vector<Message> answers_of(PartId home, std::vector<Heard>& heard) {
  std::ranges::sort(heard, {}, [](const Heard& one) { return std::tuple(one.wish.stack, one.wish.target, one.from); });
  std::vector<std::pair<PartId, Wish>> answers;
  for (std::size_t begin = 0, end = 0; begin < heard.size(); begin = end) {
    while (end < heard.size() && heard[end].wish.stack == heard[begin].wish.stack) ++end;
    const auto all = std::span(heard).subspan(begin, end - begin);
    const std::uint32_t target = most_wanted(all);
    for (const Heard& one : all)
      if (one.wish.target != target) answers.push_back({one.from, {one.wish.stack, target, 0}});
  }
  std::ranges::stable_sort(answers, {}, [](const auto& answer) { return answer.first; });
  std::vector<Message> messages;
  for (std::size_t begin = 0, end = 0; begin < answers.size(); begin = end) {
    std::vector<Wish> wishes;
    for (; end < answers.size() && answers[end].first == answers[begin].first; ++end)
      wishes.push_back(answers[end].second);
    MessageWriter writer;
    writer.put_array(std::span<const Wish>(wishes));
    messages.push_back({home, answers[begin].first, 0, writer.take()});
  }
  return messages;
}

void follow(const StackItems& items, std::span<const Wish> answers, Destinations& destinations) {
  std::vector<std::uint32_t> target(items.stacks.size(), kNone);
  for (const Wish& answer : answers)
    target[static_cast<std::size_t>(std::ranges::lower_bound(items.stacks, answer.stack) - items.stacks.begin())] =
        answer.target;
  for (std::size_t cell = 0; cell < items.cell_to_item.size(); ++cell) {
    const std::size_t item = items.cell_to_item[cell];
    if (item >= items.first_stack() && target[item - items.first_stack()] != kNone)
      destinations[cell] = target[item - items.first_stack()];
  }
}

}  // namespace

StackItems find_stack_items(const PartMesh& part) {
  StackItems items;
  items.count = part.cell_count();
  const std::vector<std::uint64_t> stacks = read_stacks(part);
  items.stacks = distinct(stacks);
  if (items.stacks.empty()) return items;
  const auto loose = static_cast<std::uint32_t>(std::ranges::count(stacks, std::uint64_t{0}));
  items.count = loose + items.stacks.size();
  items.cell_to_item.reserve(stacks.size());
  std::uint32_t next = 0;
  for (const std::uint64_t stack : stacks)
    items.cell_to_item.push_back(
        stack == 0
            ? next++
            : loose + static_cast<std::uint32_t>(std::ranges::lower_bound(items.stacks, stack) - items.stacks.begin()));
  return items;
}

Destinations destinations_of_cells(const StackItems& items, Destinations item_targets) {
  if (!items.has_stacks()) return item_targets;
  Destinations destinations(items.cell_to_item.size());
  std::ranges::transform(items.cell_to_item, destinations.begin(),
                         [&](std::uint32_t item) { return item_targets[item]; });
  return destinations;
}

void unite_stacks(const PartitionedMesh& mesh, const PerPart<StackItems>& items, PerPart<Destinations>& destinations) {
  Communicator& communicator = *mesh.communicator;
  const std::size_t parts = mesh.part_count();
  const bool has_field = std::ranges::any_of(
      mesh.cell_fields, [](const FieldInfo& field) { return field.name == kStackField && field.components == 1; });
  if (!has_field) return;
  const auto rank_of = [&](PartId part) { return communicator.rank_of(part, parts); };
  const auto tell = [&] {
    std::vector<Message> messages;
    for (const PartId part : mesh.local())
      std::ranges::move(tell_homes(part, parts, wishes_of(items.at(part), destinations.at(part))),
                        std::back_inserter(messages));
    return messages;
  };
  const std::vector<Message> told = exchange(communicator, tell, rank_of);
  const auto answer = [&] {
    std::vector<Message> messages;
    for (std::size_t begin = 0, end = 0; begin < told.size(); begin = end) {
      std::vector<Heard> heard;
      for (; end < told.size() && told[end].to == told[begin].to; ++end)
        for (const Wish& wish : MessageReader(told[end].bytes).get_view<Wish>())
          heard.push_back({wish, told[end].from});
      std::ranges::move(answers_of(told[begin].to, heard), std::back_inserter(messages));
    }
    return messages;
  };
  for (const Message& message : exchange(communicator, answer, rank_of))
    follow(items.at(message.to), MessageReader(message.bytes).get_view<Wish>(), destinations.at(message.to));
}

}  // namespace tetloom::balance_detail
