#pragma once
// Parts ask where open balls of their tets reach to, in rounds, until no part learns anything new.
#include "mesher/parts/all_parts.hpp"

namespace tetloom::parts {

/// How much there was to ask.
struct Asked {
  std::size_t rounds = 0;
  std::size_t tets = 0;  ///< of all parts, in the first round
};

/// The same on all ranks. A collective call. Errors: Cancelled.
Asked ask_others(const AllParts& parts);

}  // namespace tetloom::parts
