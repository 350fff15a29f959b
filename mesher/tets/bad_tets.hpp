#pragma once
// The tets that a pass visits.
#include <algorithm>
#include <array>
#include <cstdint>

#include "core/tets/many_values.hpp"
#include "core/tets/working_mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

/// Calls visit(tet) for the tets of cubed quality below `limit` among those that are there at the start, in ascending
/// order. Tets are found a block ahead, so that what a visit reads is under way before it; each is looked at again just
/// before its visit. `visit` may change the mesh. Errors: Cancelled.
template <class Visit>
void for_each_bad_tet(WorkingMesh& mesh, double limit, const TaskRunner& runner, Visit&& visit) {
  constexpr std::uint32_t kBlock = 4096, kVisitsBetweenChecks = 256;
  std::array<std::uint32_t, kBlock> bad;
  const auto bound = static_cast<float>(limit);
  const auto count = static_cast<std::uint32_t>(mesh.qualities().size());
  for (std::uint32_t begin = 0; begin < count; begin += kBlock) {
    runner.check_cancelled();
    const std::uint32_t end = std::min(count, begin + kBlock);
    const float* quality = mesh.qualities().data();
    std::uint32_t bad_count = 0;
    for_each_that(
        begin, end, [=](std::size_t tet) { return quality[tet] < bound; },
        [&](std::size_t tet) { bad[bad_count++] = static_cast<std::uint32_t>(tet); });
    for (std::uint32_t i = 0; i < bad_count; ++i) {
      if (i % kVisitsBetweenChecks == kVisitsBetweenChecks - 1) runner.check_cancelled();
      if (i + 8 < bad_count) mesh.prefetch(bad[i + 8]);
      if (i + 4 < bad_count) mesh.prefetch_neighbors(bad[i + 4]);
      if (mesh.quality(bad[i]) < bound) visit(bad[i]);
    }
  }
}

}  // namespace tetloom::tets
