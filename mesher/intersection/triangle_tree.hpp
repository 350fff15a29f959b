#pragma once
// A tree of boxes over triangles, for finding those near a place.
//
// A complete binary tree over the triangles in Morton order of their centres, so it depends on the triangles alone.
// Building is O(n log n), 0.2 s per million triangles; 4 + 2 * 24/4 bytes per triangle, or up to twice the latter.
// Immutable afterwards: queries may come from any number of threads. Refers to the arrays it was built from, which must
// outlive it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/fixed_array.hpp"
#include "tetloom/vec.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::intersection {

/// Whether a segment meets boxes (closed): the axes' and the cross products' projections are compared (Ericson 2004,
/// 5.3.3). True for boxes that rounding alone keeps apart from it.
class SegmentBoxTest {
 public:
  SegmentBoxTest(const Vec3& x, const Vec3& along)
      : middle_(x + 0.5 * along),
        half_(0.5 * along),
        absolute_{std::abs(half_.x), std::abs(half_.y), std::abs(half_.z)} {
    constexpr double kRounding = 1e-12;
    rounding_ = kRounding * (std::abs(middle_.x) + std::abs(middle_.y) + std::abs(middle_.z) + absolute_.x +
                             absolute_.y + absolute_.z);
  }
  bool operator()(const Box3& box) const {
    const Vec3 extent = 0.5 * (box.hi - box.lo) + Vec3{rounding_, rounding_, rounding_};
    const Vec3 m = middle_ - box.center();
    const Vec3 a{std::abs(m.x), std::abs(m.y), std::abs(m.z)};
    if (a.x > extent.x + absolute_.x || a.y > extent.y + absolute_.y || a.z > extent.z + absolute_.z) return false;
    const Vec3 c = cross(m, half_);
    return std::abs(c.x) <= extent.y * absolute_.z + extent.z * absolute_.y + slack(a.y, a.z) &&
           std::abs(c.y) <= extent.x * absolute_.z + extent.z * absolute_.x + slack(a.x, a.z) &&
           std::abs(c.z) <= extent.x * absolute_.y + extent.y * absolute_.x + slack(a.x, a.y);
  }

 private:
  double slack(double s, double t) const { return (s + t) * rounding_; }

  Vec3 middle_, half_, absolute_;
  double rounding_;
};

/// Triangles in a tree of boxes. Immutable; refers to the points that it was made over.
class TriangleTree {
 public:
  /// Pre: the indices are valid and the coordinates finite. Ranks share the work, and have the same tree afterwards.
  /// Errors: Cancelled.
  TriangleTree(std::span<const Vec3> points, std::span<const std::array<std::uint32_t, 3>> tri_to_vert,
               const SharedWork& work);
  /// Into how many pieces the work of making a tree of so many triangles is cut.
  static std::size_t pieces(std::size_t triangles);

  /// The arrays of the tree, not those of the triangles, are where `keep` keeps them from now on.
  void move_arrays(const KeepBytes& keep);

  /// Calls visit(triangle) for every triangle whose box overlaps `box` (closed), in the tree's own order.
  template <class Visit>
  void for_each_in(const Box3& box, Visit&& visit) const {
    descend([&](const Box3& node) { return node.overlaps(box); },
            [&](std::uint32_t triangle) {
              if (box_of(triangle).overlaps(box)) visit(triangle);
              return true;
            });
  }
  /// Calls visit(triangle) for every triangle whose box meets the segment from `x` to `x + along` (closed, up to
  /// rounding: a few more may be visited), in the tree's own order. Where triangles are much smaller than the segment
  /// is long, far fewer than the segment's box overlaps.
  template <class Visit>
  void for_each_along(const Vec3& x, const Vec3& along, Visit&& visit) const {
    const SegmentBoxTest meets(x, along);
    descend([&](const Box3& node) { return meets(node); },
            [&](std::uint32_t triangle) {
              if (meets(box_of(triangle))) visit(triangle);
              return true;
            });
  }
  /// The same of the triangles in some leaves, in their order.
  template <class Visit>
  void for_each_along(const Vec3& x, const Vec3& along, std::span<const std::size_t> leaves, Visit&& visit) const {
    const SegmentBoxTest meets(x, along);
    for (const std::size_t leaf : leaves) {
      if (!meets(box_at(first_leaf_ + leaf))) continue;
      for (const std::uint32_t triangle : leaf_triangles(leaf))
        if (meets(box_of(triangle))) visit(triangle);
    }
  }
  /// True when a point of a triangle lies nearer to `x` than `radius`.
  bool any_within(const Vec3& x, double radius) const;
  /// False when no triangle's box overlaps `box` (closed); true when one does, or nearly.
  bool may_meet(const Box3& box) const;
  /// Calls visit(triangle, up) for every triangle that a ray from `x` crosses; `up` when its normal points along the
  /// ray. The ray goes along the coordinate axis in which the triangles' box is shortest (+z of equals), so that it
  /// meets few triangles. Exact: a ray through an edge or a vertex is treated as if `x` were moved by an infinitesimal
  /// step, the same for all triangles, so that the crossings of a closed surface balance.
  template <class Visit>
  void for_each_above(const Vec3& x, Visit&& visit) const {
    if (up_ == 2) return for_each_along_axis<2>(x, visit);
    if (up_ == 1) return for_each_along_axis<1>(x, visit);
    for_each_along_axis<0>(x, visit);
  }

  static constexpr std::size_t kLeafSize = 4;
  /// Leaves hold triangles that are neighbours in space: leaf i those of leaf_triangles(i), kLeafSize but
  /// for the last.
  std::size_t leaf_count() const { return (order_.size() + kLeafSize - 1) / kLeafSize; }
  std::span<const std::uint32_t> leaf_triangles(std::size_t leaf) const {
    return order_.span().subspan(leaf * kLeafSize, std::min(kLeafSize, order_.size() - leaf * kLeafSize));
  }
  /// Calls visit(leaf) for the leaves from `first` on whose boxes overlap `box`, or nearly, ascending.
  template <class Visit>
  void for_each_leaf_in(const Box3& box, std::size_t first, Visit&& visit) const {
    descend_leaves([&](const Box3& node) { return node.overlaps(box); },
                   [&](std::size_t leaf) {
                     if (leaf >= first) visit(leaf);
                     return true;
                   });
  }
  Box3 box_of(std::uint32_t triangle) const;
  const std::array<std::uint32_t, 3>& verts_of(std::uint32_t triangle) const { return tri_to_vert_[triangle]; }
  std::array<Vec3, 3> corners_of(std::uint32_t triangle) const {
    const auto& [a, b, c] = tri_to_vert_[triangle];
    return {points_[a], points_[b], points_[c]};
  }

 private:
  // Visits the leaves under nodes that `enter` lets through until `visit_leaf` returns false.
  template <class Enter, class VisitLeaf>
  void descend_leaves(Enter&& enter, VisitLeaf&& visit_leaf) const {
    if (order_.empty() || !enter(box_at(1))) return;
    std::array<std::size_t, 128> stack;
    std::size_t depth = 0;
    stack[depth++] = 1;
    while (depth > 0) {
      const std::size_t node = stack[--depth];
      if (node >= first_leaf_) {
        if (!visit_leaf(node - first_leaf_)) return;
        continue;
      }
      const std::size_t first = 2 * node, second = first + 1;
      if (second < nodes_.size() && enter(box_at(second))) stack[depth++] = second;
      if (first < nodes_.size() && enter(box_at(first))) stack[depth++] = first;
    }
  }
  template <class Enter, class Visit>
  void descend(Enter&& enter, Visit&& visit) const {
    descend_leaves(enter, [&](std::size_t leaf) {
      for (const std::uint32_t triangle : leaf_triangles(leaf)) {
        if (!visit(triangle)) return false;
      }
      return true;
    });
  }
  template <int Up, class Visit>
  void for_each_along_axis(const Vec3& x, Visit& visit) const {
    constexpr int kU = (Up + 1) % 3, kV = (Up + 2) % 3;
    descend(
        [&](const Box3& n) {
          return n.lo[kU] <= x[kU] && x[kU] <= n.hi[kU] && n.lo[kV] <= x[kV] && x[kV] <= n.hi[kV] && n.hi[Up] >= x[Up];
        },
        [&](std::uint32_t triangle) {
          if (const int side = crossing_above(triangle, x); side != 0) visit(triangle, side > 0);
          return true;
        });
  }
  /// A box as seen from `origin_`, a little too large by rounding.
  struct Node {
    std::array<float, 3> lo{HUGE_VALF, HUGE_VALF, HUGE_VALF}, hi{-HUGE_VALF, -HUGE_VALF, -HUGE_VALF};

    void add(const Node& other) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lo[axis] = std::min(lo[axis], other.lo[axis]);
        hi[axis] = std::max(hi[axis], other.hi[axis]);
      }
    }
  };
  Box3 leaf_box(std::size_t leaf) const;
  Node node_of(const Box3& box) const;
  Box3 box_at(std::size_t node) const {
    const auto& [lo, hi] = nodes_[node];
    return {origin_ + Vec3{lo[0], lo[1], lo[2]}, origin_ + Vec3{hi[0], hi[1], hi[2]}};
  }
  std::vector<std::uint32_t> sort_triangles(const Box3& around, const SharedWork& work) const;
  int crossing_above(std::uint32_t triangle, const Vec3& x) const;

  std::span<const Vec3> points_;
  std::span<const std::array<std::uint32_t, 3>> tri_to_vert_;
  FixedArray<std::uint32_t> order_;  // triangles in Morton order
  FixedArray<Node> nodes_;           // heap order, root at 1; the last level ends with the last leaf
  Vec3 origin_;
  double rounding_ = 0;  // of what is seen from there
  std::size_t first_leaf_ = 1;
  int up_ = 2;  // the axis of rays
};

}  // namespace tetloom::intersection
