#pragma once
// The shares of all ranks become a mesh in parts, where they lie.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/parts/share.hpp"
#include "adapt/parts/umbrellas.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::adapt {

/// Fields on the vertices or tets of a share: all components of all fields side by side.
struct ShareFields {
  std::vector<FieldInfo> infos;
  std::span<const double> values;
};

/// What parts are made of.
struct SharePieces {
  WholeMesh& share;               ///< after a round; emptied
  const ShareLinks& links;        ///< of that round
  const TouchingVerts& touching;  ///< see separate_umbrellas
  const Mesh& source;             ///< its names, sides and entities are those of the parts
  ShareFields on_points, on_tets;
};

/// A mesh in parts, and what is asked for at the vertices of each.
struct PartsWithMetric {
  PartitionedMesh mesh;
  PerPart<GrowingArray<VertexMetric>> to_metric;
};

/// The vertices of a part's tets.
std::vector<std::array<std::uint32_t, 4>> tets_of(const PartMesh& part);

/// The mesh of gather_shares, join_umbrellas and make_mesh_of, in the `part_count` parts of the last round, each on the
/// rank that has changed it: nothing but numbers of touching vertices travels, before parts find their links. Global
/// ids are numbers in that mesh. It depends on the parts alone. In SharedWork::together. Errors: those of link_parts.
PartsWithMetric make_parts(const SharePieces& pieces, std::size_t part_count, const SharedWork& work);

}  // namespace tetloom::adapt
