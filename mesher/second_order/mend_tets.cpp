#include "mesher/second_order/mend_tets.hpp"

#include <algorithm>

#include "core/tets/tet_quality.hpp"
#include "mesher/second_order/bad_patches.hpp"
#include "mesher/second_order/exchange_patches.hpp"
#include "mesher/second_order/patch_mender.hpp"

namespace tetloom::second_order {
namespace {

constexpr double kLeastQuality = 0.2;  // mean ratio of a tet that is made; less only where it was less before
constexpr int kRounds = 3;

double cubed_quality_of(const tets::TetMesh& mesh, std::uint32_t tet) {
  return tets::cubed_quality(mesh.point_of(tet, 0), mesh.point_of(tet, 1), mesh.point_of(tet, 2),
                             mesh.point_of(tet, 3));
}

// Returns how many gave way. A tet that is made may be asked again under its number, which does no harm.
std::size_t mend_patch(BadPatch& patch, const CurvedJudge& judge) {
  double floor = tets::cube(kLeastQuality);
  for (const std::uint32_t tet : patch.bad) floor = std::min(floor, cubed_quality_of(patch.tets, tet));
  PatchMender mender(patch.tets, judge, floor);
  std::size_t mended = 0;
  for (int round = 0; round < kRounds; ++round) {
    const std::size_t before = mended;
    for (const std::uint32_t tet : patch.bad)
      if (!mender.is_dead(tet) && !mender.is_good(tet)) mended += mender.mend(tet);
    if (mended == before) break;
    mender.smooth();
  }
  return mended;
}

}  // namespace

std::size_t mend_tets(std::span<const std::uint32_t> bad, double least, std::vector<CurvedNode>& curved, Mesh& mesh,
                      const TaskRunner& runner) {
  std::vector<BadPatch> patches = find_bad_patches(mesh, bad, runner);
  std::vector<std::size_t> mended(patches.size(), 0);
  const MidNodes mids(mesh);
  runner.for_each(patches.size(), [&](std::size_t p) {
    const CurvedJudge judge(mesh, mids, least, patches[p].to_vert, patches[p].tets);
    mended[p] = mend_patch(patches[p], judge);
  });
  std::size_t sum = 0, changed = 0;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    sum += mended[p];
    if (mended[p] > 0 && changed++ != p) patches[changed - 1] = std::move(patches[p]);
  }
  patches.resize(changed);
  if (sum > 0) exchange_patches(patches, curved, mesh);
  return sum;
}

}  // namespace tetloom::second_order
