#pragma once
// Which points and triangles of the surface each part knows.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/parts/decomposition.hpp"
#include "mesher/volume/complex.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// All ranks hold the whole surface: it is small beside the volume.
class PartSurface {
 public:
  /// A part knows the points within `reach` of their size of its box, those of the triangles at points that it owns,
  /// those of larger triangles that may meet its box, and the triangles between all these. So it knows all
  /// triangles that meet its box.
  PartSurface(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition, double reach,
              const TaskRunner& runner);

  /// Into how many pieces the work on most of the surface is cut.
  static std::size_t pieces(const volume::Complex& complex);

  /// Forgets what all other parts know.
  void keep(std::span<const PartId> parts);

  std::span<const std::uint32_t> points_of(PartId part) const { return part_to_points_[part.value]; }  ///< ascending
  std::span<const std::uint32_t> triangles_of(PartId part) const {
    return part_to_triangles_[part.value];
  }  ///< ascending
  PartId owner_of(std::uint32_t point) const { return point_to_owner_[point]; }

 private:
  std::vector<PartId> point_to_owner_;
  std::vector<std::vector<std::uint32_t>> part_to_points_, part_to_triangles_;
};

}  // namespace tetloom::parts
