#pragma once
// Graph partitioning of cells that lie in several parts.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/part/adjacency.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::balance_detail {

/// Cells and what they share faces with: rows of offsets, first of all one of 0.
template <class Index>
struct CellLinks {
  std::vector<std::uint64_t> first{0};
  std::vector<Index> neighbours;

  /// Adds the cells of a part, in the order of their numbers. behind(face) is the number of the cell of another part
  /// behind a face that is open in this one, or none; faces ascend from call to call.
  template <class Behind>
  void add(const PartMesh& part, const CellNumbers& numbers, const Behind& behind);
  /// Adds them without anything behind open faces.
  void add(const PartMesh& part, const CellNumbers& numbers) {
    add(part, numbers, [](CellPlace) { return std::optional<Index>(); });
  }
};

/// Cuts the graph of all cells of all parts anew, by Scotch where there is one rank and by Zoltan where there are more.
/// `weights` are positive, one per cell, or empty in all parts. A collective call; the whole graph stands in memory,
/// some 60 bytes per tet. The result depends on the number of ranks as well where there are several.
void partition_spread_graph(const PartitionedMesh& mesh, const PerPart<std::vector<std::int64_t>>& weights,
                            std::uint32_t part_count, double imbalance, PerPart<Destinations>& destinations,
                            const TaskRunner& runner);

template <class Index>
template <class Behind>
void CellLinks<Index>::add(const PartMesh& part, const CellNumbers& numbers, const Behind& behind) {
  for (const CellKind kind : kAllCellKinds) {
    const CellBlock& block = part.block(kind);
    const std::uint32_t faces = shape_of(kind).face_count;
    for (std::uint32_t cell = 0; cell < block.size(); ++cell) {
      for (std::uint32_t face = 0; face < faces; ++face) {
        const CellPlace place = block.to_neighbor[std::size_t{cell} * faces + face];
        if (place.valid()) {
          neighbours.push_back(static_cast<Index>(numbers.number_of(place)));
        } else if (const std::optional<Index> other = behind(CellPlace(kind, cell, face))) {
          neighbours.push_back(*other);
        }
      }
      first.push_back(neighbours.size());
    }
  }
}

}  // namespace tetloom::balance_detail
