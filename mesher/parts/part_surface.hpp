#pragma once
// Which points and triangles of the surface each part knows.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/parts/decomposition.hpp"
#include "mesher/volume/complex.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::parts {

/// Of the parts of this rank. All ranks hold the whole surface: it is small beside the volume. Refers to the complex's
/// points and to the decomposition.
class PartSurface {
 public:
  /// A part knows the points within `reach` of their size of its box, those of the triangles at points that it owns,
  /// those of larger triangles that may meet its box, and the triangles between all these. So it knows all
  /// triangles that meet its box. All ranks call it, in `together`.
  PartSurface(const volume::Complex& complex, const SizeField& sizes, const Decomposition& decomposition, double reach,
              const SharedWork& work);

  /// Into how many pieces the work on most of the surface is cut.
  static std::size_t pieces(const volume::Complex& complex);

  std::span<const std::uint32_t> points_of(PartId part) const { return part_to_points_[part.value]; }  ///< ascending
  std::span<const std::uint32_t> triangles_of(PartId part) const {
    return part_to_triangles_[part.value];
  }                                                                                                ///< ascending
  PartId owner_of(std::uint32_t point) const { return decomposition_->owner_of(points_[point]); }  ///< any rank's

 private:
  std::span<const Vec3> points_;
  const Decomposition* decomposition_;
  std::vector<std::vector<std::uint32_t>> part_to_points_, part_to_triangles_;
};

}  // namespace tetloom::parts
