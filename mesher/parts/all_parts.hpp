#pragma once
// All parts at once, between schedules: what the ranks do together.
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mesher/parts/part_state.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// Refers to what must outlive it. All functions are collective calls.
struct AllParts {
  const SharedInput& input;
  PerPart<PartState>& states;  ///< those of this rank
  Communicator& communicator;
  const TaskRunner& runner;
  Trace* trace = nullptr;  ///< may be null

  /// Calls body(i) for each part of this rank, side by side; recorded as one loop of this name. Not a collective call.
  void for_each_local(const char* name, const std::function<void(std::size_t)>& body) const;
  bool any_fault() const;
  /// What `make` makes for other parts, to the ranks that have them; as tetloom::exchange.
  std::vector<Message> exchange(const std::function<std::vector<Message>()>& make) const;
  /// Not a collective call: all ranks have found the same.
  void set_fault(const std::string& message) const;
};

}  // namespace tetloom::parts
