#pragma once
// One round of adaptation: the mesh dealt to parts, each of which is changed on its own, and put together again.
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "adapt/kernel/cavity_mesh.hpp"
#include "adapt/kernel/side_splits.hpp"
#include "adapt/metric/background_tiles.hpp"
#include "adapt/parts/share.hpp"
#include "adapt/parts/whole_mesh.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// Around the points of all shares. In together.
Box3 box_of(const WholeMesh& share, const SharedWork& work);

/// The work of all tets of all ranks; added up in whole numbers, so in any order. In together.
double sum_of_work(std::span<const float> to_work, const SharedWork& work);

/// How a mesh is dealt to parts.
struct Dealing {
  GrowingArray<std::uint32_t> to_part;  ///< of every tet
  std::vector<std::int64_t> work;       ///< of every part, on all ranks, in units
};

/// `part_count` parts of equal shares of the work along a Hilbert curve. The curve differs from round to round, and so
/// do the sides of parts. `to_work`: positive, one per tet. In together.
Dealing deal_tets(const WholeMesh& share, const ShareLinks& links, std::span<const float> to_work,
                  std::size_t part_count, std::size_t round, const SharedWork& work);

/// What is done in a round.
struct RoundWork {
  std::function<void(std::size_t, CavityMesh&)> adapt;  ///< each part, by its number
  const MetricStage* source = nullptr;                  ///< where `sides` have an end to lengths
  SideSplitOptions sides = {};                          ///< of edges between parts, before
  BackgroundTiles* tiles = nullptr;                     ///< that `source` looks up in; null: it needs none
};

/// Cuts, splits edges between parts, calls `adapt` for every part on one rank, the one of most work first, and puts
/// together what has become of them. The result depends on the parts alone. Returns how many edges between parts were
/// split, each of them counted on one rank. In together; where it throws, what is left is of no use.
std::size_t adapt_in_parts(WholeMesh& share, ShareLinks& links, Dealing&& dealing, const RoundWork& round,
                           const SharedWork& work);

}  // namespace tetloom::adapt
