#pragma once
// Which points and triangles of the surface each part knows.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/parts/decomposition.hpp"
#include "mesher/volume/complex.hpp"
#include "threading/task_runner.hpp"

namespace tetloom::parts {

/// Immutable. All ranks hold the whole surface: it is small beside the volume.
class PartSurface {
 public:
  /// A part knows the points within `reach` of their size of its box, those of the triangles at points that it owns,
  /// and the triangles all of whose points it knows.
  PartSurface(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition, double reach,
              const TaskRunner& runner);

  std::span<const std::uint32_t> points_of(PartId part) const { return slice(points_, part); }        ///< ascending
  std::span<const std::uint32_t> triangles_of(PartId part) const { return slice(triangles_, part); }  ///< ascending
  PartId owner_of(std::uint32_t point) const { return point_to_owner_[point]; }

 private:
  struct Lists {
    std::vector<std::uint32_t> items, first;  // first: per part, and one past the last
  };
  struct Pair;
  Lists deal(std::span<const std::vector<Pair>> block_to_pairs, std::size_t part_count) const;
  static std::span<const std::uint32_t> slice(const Lists& lists, PartId part) {
    return std::span(lists.items)
        .subspan(lists.first[part.value], lists.first[part.value + 1] - lists.first[part.value]);
  }

  std::vector<PartId> point_to_owner_;
  Lists points_, triangles_;
};

}  // namespace tetloom::parts
