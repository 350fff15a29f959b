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

/// Immutable after construction; refers to the points and triangles, which must outlive it. The tree depends on them
/// alone. Thread safety: queries may run at once. Complexity: O(n log n) to build, under 80 bytes a triangle.
class FacetBvh {
 public:
  FacetBvh() = default;
  FacetBvh(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert);

  /// The nearest point of all triangles that is nearer than `start`, or `start` itself.
  FacetPoint closest(const Vec3& x, FacetPoint start = {}) const { return closest_facing(x, {}, start); }
  /// The same of the triangles that do not face away from `direction`; all where it is zero.
  FacetPoint closest_facing(const Vec3& x, const Vec3& direction, FacetPoint start) const;
  /// Calls visit(tri) for the triangles whose boxes the ray from `origin` along `direction` touches.
  void for_each_near_ray(const Vec3& origin, const Vec3& direction,
                         const std::function<void(std::uint32_t)>& visit) const;

 private:
  /// Children follow in the array: the first at once, the second at `second`. Leaves have a `count` > 0.
  struct Node {
    Box3 box;
    std::uint32_t second = 0, begin = 0, count = 0;
  };
  void build(std::uint32_t begin, std::uint32_t end, std::span<const Vec3> centroids);

  std::span<const Vec3> points_;
  std::span<const Triangle> tri_to_vert_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace tetloom::detail
