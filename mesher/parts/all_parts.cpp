#include "mesher/parts/all_parts.hpp"

#include <array>

#include "threading/comm/exchange.hpp"

namespace tetloom::parts {

void AllParts::for_each_local(const char* name, const std::function<void(std::size_t)>& body) const {
  const std::size_t count = states.local().size();
  const TraceSpan span(trace, name, runner.threads(), count);
  runner.for_each(count, body);
}

bool AllParts::any_fault() const {
  std::uint64_t count = 0;
  for (const PartId part : states.local()) count += states.at(part).fault.any();
  return sum(count) > 0;
}

std::uint64_t AllParts::sum(std::uint64_t of_this_rank) const {
  std::array<std::int64_t, 1> total{static_cast<std::int64_t>(of_this_rank)};
  communicator.sum(total);
  return static_cast<std::uint64_t>(total[0]);
}

std::vector<Message> AllParts::exchange(std::vector<Message> messages) const {
  return tetloom::exchange(communicator, std::move(messages),
                           [&](PartId part) { return communicator.rank_of(part, states.part_count()); });
}

void AllParts::set_fault(const std::string& message) const {
  for (const PartId part : states.local()) states.at(part).fault.message = message;
}

}  // namespace tetloom::parts
