#pragma once
// A tree of boxes over triangles, for nearest points and rays. Private to core/discrete.
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/discrete/facet_soup.hpp"
#include "core/spatial/bvh.hpp"
#include "core/spatial/distances.hpp"
#include "tetloom/ids.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::detail {

/// A place on a facet.
struct FacetPoint {
  std::uint32_t tri = kNone;
  TrianglePoint place;
};

/// Directions of unit length, at right angles to each other.
struct OrthogonalFrame {
  std::array<Vec3, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  bool is_along_axes = true;
  /// The coordinates of a vector in the frame.
  Vec3 operator()(const Vec3& x) const { return {dot(x, axes[0]), dot(x, axes[1]), dot(x, axes[2])}; }
};

/// Immutable after construction; refers to the points and triangles, which must outlive it. The tree depends on them
/// alone. Boxes stand along the axes, or along the longest edge where those of the facets are far smaller that way:
/// long thin facets along a line that is no axis would have boxes that overlap everywhere. For the same reason facets
/// far longer than their fellows are in the tree piece by piece (Ernst & Greiner, Early split clipping for bounding
/// volume hierarchies, 2007). Thread safety: queries may run at once. Complexity: O(n log n) to build for n pieces,
/// under 80 bytes a piece; without long facets as many as triangles, else at most four times as many or a quarter of a
/// million.
class FacetBvh {
 public:
  FacetBvh() = default;
  FacetBvh(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert);

  /// The nearest point of all triangles that is nearer than `start`, or `start` itself; that of the first triangle
  /// where several are as near.
  FacetPoint closest(const Vec3& x, FacetPoint start = {}) const { return closest_facing(x, {}, start); }
  /// The same of the triangles that do not face away from `direction`; all where it is zero.
  FacetPoint closest_facing(const Vec3& x, const Vec3& direction, FacetPoint start) const;
  /// Calls visit(tri) for the triangles whose boxes the ray from `origin` along `direction` touches, for long ones
  /// perhaps several times.
  void for_each_near_ray(const Vec3& origin, const Vec3& direction,
                         const std::function<void(std::uint32_t)>& visit) const;

 private:
  /// A facet, or what lies of it between two planes across its box; in the frame.
  struct Pieces {
    std::vector<Box3> boxes;
    std::vector<std::uint32_t> facets;
  };
  Pieces cut_facets() const;

  OrthogonalFrame frame_;  // of the boxes
  std::span<const Vec3> points_;
  std::span<const Triangle> tri_to_vert_;
  Bvh bvh_;
  std::vector<std::uint32_t> facets_;  // in the order of the tree
};

}  // namespace tetloom::detail
