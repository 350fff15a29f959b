#include "mesher/parts/all_parts.hpp"

#include "threading/comm/collectives.hpp"

namespace tetloom::parts {

void AllParts::for_each_local(const char* name, const std::function<void(std::size_t)>& body) const {
  const std::size_t count = states.local().size();
  const TraceSpan span(trace, name, runner.threads(), count);
  runner.for_each(count, body);
}

bool AllParts::any_fault() const {
  std::uint64_t count = 0;
  for (const PartId part : states.local()) count += states.at(part).fault.any();
  return sum_over_ranks(communicator, count) > 0;
}

std::vector<Message> AllParts::exchange(const std::function<std::vector<Message>()>& make) const {
  return tetloom::exchange(communicator, make,
                           [&](PartId part) { return communicator.rank_of(part, states.part_count()); });
}

void AllParts::set_fault(const std::string& message) const {
  for (const PartId part : states.local()) states.at(part).fault.message = message;
}

}  // namespace tetloom::parts
