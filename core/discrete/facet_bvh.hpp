#pragma once
// A tree of boxes over triangles, for nearest points and rays. Private to core/discrete.
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/discrete/facet_soup.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::detail {

/// A point of a facet: (1 - b1 - b2)·p0 + b1·p1 + b2·p2.
struct FacetPoint {
  std::uint32_t tri = 0xffffffffu;
  double b1 = 0, b2 = 0;
  Vec3 point;
  double distance2 = HUGE_VAL;
};

/// The point of triangle p0 p1 p2 nearest to x (Ericson, Real-Time Collision Detection, 2005, §5.1.5); `tri` is left
/// alone. Degenerate triangles give a point of theirs.
FacetPoint closest_on_triangle(const Vec3& x, const Vec3& p0, const Vec3& p1, const Vec3& p2);

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

  /// The nearest point of all triangles that is nearer than `start`, or `start` itself.
  FacetPoint closest(const Vec3& x, FacetPoint start = {}) const { return closest_facing(x, {}, start); }
  /// The same of the triangles that do not face away from `direction`; all where it is zero.
  FacetPoint closest_facing(const Vec3& x, const Vec3& direction, FacetPoint start) const;
  /// Calls visit(tri) for the triangles whose boxes the ray from `origin` along `direction` touches, for long ones
  /// perhaps several times.
  void for_each_near_ray(const Vec3& origin, const Vec3& direction,
                         const std::function<void(std::uint32_t)>& visit) const;

 private:
  /// Children follow in the array: the first at once, the second at `second`. Leaves have a `count` > 0.
  struct Node {
    Box3 box;
    std::uint32_t second = 0, begin = 0, count = 0;
  };
  /// A facet, or what lies of it between two planes across its box; in the frame.
  struct Piece {
    Box3 box;
    Vec3 center;
    std::uint32_t tri;
  };
  std::vector<Piece> cut_facets() const;
  void build(std::uint32_t begin, std::uint32_t end, std::span<Piece> pieces);

  OrthogonalFrame frame_;  // of the boxes
  std::span<const Vec3> points_;
  std::span<const Triangle> tri_to_vert_;
  std::vector<std::uint32_t> facets_;  // of the leaves
  std::vector<Node> nodes_;
};

}  // namespace tetloom::detail
