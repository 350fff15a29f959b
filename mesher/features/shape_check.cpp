#include "mesher/features/shape_check.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/lists.hpp"
#include "core/spatial/triangle_shape.hpp"
#include "mesher/features/cone.hpp"

namespace tetloom::features {
namespace {

constexpr double kRegionFold = 15 * std::numbers::pi / 180, kVoidFold = 0.3 * std::numbers::pi / 180;
// A region may be left with a smaller wedge, down to this, where the wedge is so many times the angle that the feature
// has as it is.
constexpr double kLeastRegionFold = 1 * std::numbers::pi / 180, kFoldGain = 2;
// Nothing is meshed in a slit: its floor may go where it is so narrow that its sides are nearly parallel by then.
constexpr double kVoidShare = 0.2, kLeastVoidFold = 1e-6;
constexpr double kLeastCosine = 0.17;  // of the angle that a triangle may turn by
constexpr double kKeptShare = 0.67;    // of an angle that was below the limits already

Vec3 area_vector(const std::array<Vec3, 3>& x) { return cross(x[1] - x[0], x[2] - x[0]); }

/// A triangle of the surface as it will be, at one of its corners.
struct TriangleCorner {
  const Triangle& verts;
  std::uint32_t source;  ///< the triangle of the present surface that it is or replaces
};

class FoldCheck {
 public:
  FoldCheck(const SurfaceComplex& surface, const LocalChange& change)
      : surface_(surface),
        change_(change),
        region_fold_(std::clamp(kFoldGain * angle_of_feature(), kLeastRegionFold, kRegionFold)),
        void_fold_(std::clamp(kVoidShare * angle_of_feature(), kLeastVoidFold, kVoidFold)) {}

  bool run() const {
    for (std::size_t i = 0; i < change_.added.size(); ++i)
      for (const std::uint32_t v : change_.added[i].verts)
        if (folds_at(v, i)) return false;
    return true;
  }

 private:
  // The smallest angle of a tet across the feature: the length that is merged over the longest edge beside it.
  double angle_of_feature() const {
    double longest2 = 0;
    for (const std::uint32_t t : change_.removed) {
      const auto [a, b, c] = corners(surface_, t);
      longest2 = std::max({longest2, norm2(b - a), norm2(c - b), norm2(a - c)});
    }
    return longest2 > 0 ? merged_length() / std::sqrt(longest2) : 0;
  }

  double merged_length() const {
    if (change_.gone != kNone) return distance(surface_.point(change_.gone), surface_.point(change_.kept));
    const Vec3 &u = surface_.point(change_.split[0]), &v = surface_.point(change_.split[1]);
    return norm(cross(v - u, surface_.point(change_.kept) - u)) / distance(u, v);
  }

  const Vec3& after(std::uint32_t v) const { return v == change_.kept ? change_.place : surface_.point(v); }
  const Vec3& before(std::uint32_t v) const { return surface_.point(v); }

  template <class Position>
  static Cone cone_at(std::uint32_t v, const Triangle& verts, Position&& position) {
    const auto i = static_cast<std::size_t>(std::ranges::find(verts, v) - verts.begin());
    return make_cone(position(verts[i]), position(verts[(i + 1) % 3]), position(verts[(i + 2) % 3]));
  }

  bool folds_at(std::uint32_t v, std::size_t number) const {
    const AddedTriangle& added = change_.added[number];
    const Cone cone = cone_at(v, added.verts, [&](std::uint32_t w) { return after(w); });
    for (std::size_t i = number + 1; i < change_.added.size(); ++i)
      if (has(change_.added[i].verts, v) && folds(v, added, cone, {change_.added[i].verts, change_.added[i].source}))
        return true;
    for (const std::uint32_t t : surface_.triangles_at(v))
      if (!has(change_.removed, t) && folds(v, added, cone, {surface_.triangle(t), t})) return true;
    return false;
  }

  bool folds(std::uint32_t v, const AddedTriangle& added, const Cone& cone, const TriangleCorner& other) const {
    const Cone near = cone_at(v, other.verts, [&](std::uint32_t w) { return after(w); });
    const FaceSides sides = surface_.sides(added.source);
    const bool in_region = (dot(cone.normal, near.middle) > 0 ? sides.front : sides.back).valid();
    const double limit = in_region ? region_fold_ : void_fold_;
    const double now = separation(cone, near, limit);
    return now < 1 && now < kKeptShare * separation_before(v, added.source, other.source, limit);
  }

  // Infinite where the two did not meet at a corner. A vertex inside of a face is no feature that holds two surfaces
  // apart: what is at the one that it goes into was as near to its triangles before, but for the place.
  double separation_before(std::uint32_t v, std::uint32_t source, std::uint32_t other, double limit) const {
    const Triangle &s = surface_.triangle(source), &t = surface_.triangle(other);
    const auto position = [&](std::uint32_t w) { return before(w); };
    for (const std::uint32_t corner : {v, change_.gone})
      if (corner != kNone && has(s, corner) && has(t, corner))
        return separation(cone_at(corner, s, position), cone_at(corner, t, position), limit);
    if (change_.gone == kNone || surface_.entity(change_.gone).dim < 2) return HUGE_VAL;
    if (has(s, change_.gone) && has(t, change_.kept))
      return separation(cone_at(change_.gone, s, position), cone_at(change_.kept, t, position), limit);
    return HUGE_VAL;
  }

  const SurfaceComplex& surface_;
  const LocalChange& change_;
  double region_fold_;  // radians: the smallest wedge that a region may be left with
  double void_fold_;    // outside of regions
};

template <class Measure>
BeforeAfter compare(const SurfaceComplex& surface, const LocalChange& change, Measure&& measure) {
  BeforeAfter result;
  for (const std::uint32_t t : change.removed) {
    const auto [a, b, c] = corners(surface, t);
    result.before = std::min(result.before, measure(a, b, c));
  }
  for (const AddedTriangle& added : change.added) {
    const auto [a, b, c] = corners(surface, change, added.verts);
    result.after = std::min(result.after, measure(a, b, c));
  }
  return result;
}

}  // namespace

double least_height(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest2 = std::max({norm2(b - a), norm2(c - b), norm2(a - c)});
  return longest2 > 0 ? norm(cross(b - a, c - a)) / std::sqrt(longest2) : 0;
}

std::array<Vec3, 3> corners(const SurfaceComplex& surface, std::uint32_t triangle) {
  const auto& [a, b, c] = surface.triangle(triangle);
  return {surface.point(a), surface.point(b), surface.point(c)};
}

std::array<Vec3, 3> corners(const SurfaceComplex& surface, const LocalChange& change, const Triangle& verts) {
  const auto position = [&](std::uint32_t v) { return v == change.kept ? change.place : surface.point(v); };
  return {position(verts[0]), position(verts[1]), position(verts[2])};
}

BeforeAfter compare_heights(const SurfaceComplex& surface, const LocalChange& change) {
  return compare(surface, change, least_height);
}

BeforeAfter compare_shapes(const SurfaceComplex& surface, const LocalChange& change) {
  return compare(surface, change, triangle_mean_ratio);
}

bool keeps_shape(const SurfaceComplex& surface, const LocalChange& change, double tolerance) {
  for (const AddedTriangle& added : change.added) {
    const std::array<Vec3, 3> before = corners(surface, added.source), after = corners(surface, change, added.verts);
    const Vec3 s = normalized(area_vector(before)), t = normalized(area_vector(after));
    if (norm2(t) == 0) return false;
    if (least_height(before[0], before[1], before[2]) > 0.5 * tolerance && dot(s, t) < kLeastCosine) return false;
  }
  return FoldCheck(surface, change).run();
}

}  // namespace tetloom::features
