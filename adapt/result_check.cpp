#include "adapt/result_check.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/base/lists.hpp"
#include "core/predicates/predicates.hpp"
#include "tetloom/error.hpp"

namespace tetloom::adapt {

void check_positive(const TetView& mesh, const BlockLoop& loop) {
  constexpr std::size_t kGrain = std::size_t{1} << 14, kShown = 8;
  using Tets = std::vector<std::uint64_t>;
  const auto of_blocks =
      map_blocks(loop, mesh.tets.size(), kGrain, Tets(), [&](std::size_t begin, std::size_t end, Tets& found) {
        for (std::size_t tet = begin; tet < end; ++tet) {
          const auto& [a, b, c, d] = mesh.tets[tet];
          if (orient3d(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) <= 0) found.push_back(tet);
        }
      });
  Tets all = joined(of_blocks);
  if (all.empty()) return;
  const std::string message = "adaptation has left " + std::to_string(all.size()) + " tetrahedra flat or inverted";
  const Vec3 place = mesh.points[mesh.tets[all[0]][0]];
  all.resize(std::min(all.size(), kShown));
  throw Error(Diagnostic{ErrorCode::Internal, message, {}, place, std::move(all)});
}

}  // namespace tetloom::adapt
