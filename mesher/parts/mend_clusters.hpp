#pragma once
// All missing triangles recovered: gathered, dealt to parts in clusters, and what that changes told to all.
#include <vector>

#include "mesher/parts/all_parts.hpp"
#include "mesher/parts/mend_surface.hpp"

namespace tetloom::parts {

/// What recovering missing triangles has changed.
struct Mending {
  std::vector<TetKeys> removed;                   ///< tets of the shell, of any part, that are no more, ascending
  PerPart<std::vector<RecoveredTets>> recovered;  ///< those that each part has instead
};

/// Sets the fault of parts where triangles could not be recovered, or are too many. A collective call. Errors:
/// Cancelled.
Mending mend_surface(const AllParts& parts);

}  // namespace tetloom::parts
