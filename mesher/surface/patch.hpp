#pragma once
// The mesh of one model face while it is being made: topology, and for every vertex where it lies on the surface.
//
// A patch lives in one of two worlds. With a *smooth* parametrisation, vertices have coordinates in the face's plane,
// which is (u,v) scaled per axis to model length on average; triangles are valid when they are counter-clockwise
// there, and a vertex moves by moving in the plane. Without one, vertices move in their tangent plane and are
// projected back; triangles are valid when their normals agree with the surface's. Lengths, angles and qualities are
// measured in space in both.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/spatial/triangulation.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// Where a vertex lies: plane coordinates (smooth) or (u,v) of the face (facets), the point in space, the derivatives
/// along the two plane axes (for facets: two orthonormal tangents) and the unit normal (zero where undefined).
struct PatchPlace {
  Vec2 plane;
  Vec3 point, du, dv, normal;
};

/// A place of facets, with tangents made of its normal.
PatchPlace place_in_space(const Vec2& uv, const Vec3& point, const Vec3& normal);

/// Nodes of vertices that hold still while the patch is changed; those of the model are numbered below.
inline constexpr std::uint32_t kStill = 0x80000000u;

/// A vertex of a patch: its place, the size wanted there, its node.
struct PatchVertex {
  PatchPlace place;
  double size = 0;                            ///< target edge length here
  std::uint32_t node = Triangulation::kNone;  ///< the mesh node of a rim vertex; none inside
};

/// Triangles of one face, with the places of their vertices.
struct Patch {
  Triangulation topology;
  std::vector<PatchVertex> vertices;  ///< indexed as in `topology`
  bool has_poles = false;             ///< several vertices share a node and a point
};

/// Renumbers the vertices that are not on the rim, and the triangles, along a space-filling curve of the plane, so that
/// neighbours are near in memory.
void sort_spatially(Patch& patch);

/// Evaluates places on one face for one task.
class PatchSurface {
 public:
  /// In the plane; `scale` maps (u,v) to plane coordinates, axis by axis. Pre: the parametrisation is smooth.
  PatchSurface(FaceGeometry& face, const SizeField& sizes, Vec2 scale)
      : face_(face), sizes_(sizes), scale_(scale), smooth_(true) {}
  /// In space, by projection.
  PatchSurface(FaceGeometry& face, const SizeField& sizes) : face_(face), sizes_(sizes), smooth_(false) {}

  bool smooth() const { return smooth_; }
  PatchPlace at_plane(const Vec2& plane) const;
  PatchPlace nearest(const Vec3& x, const Vec2& guess) const;
  /// The place reached from `from` by the step (a, b) along its du and dv.
  PatchPlace displaced(const PatchPlace& from, const Vec2& step) const;
  PatchPlace midpoint(const PatchPlace& a, const PatchPlace& b) const;
  /// Whether the triangle is valid (see the top of this file).
  bool oriented(const PatchPlace& a, const PatchPlace& b, const PatchPlace& c) const;
  /// Length of the edge ab along the surface: the chord, or what the plane says where that is longer because the edge
  /// bends around the face. Exact to first order; a pole at one end does not lengthen it.
  double edge_length(const PatchPlace& a, const PatchPlace& b) const;
  double size_at(const Vec3& x) const { return sizes_.size_at(x); }

 private:
  FaceGeometry& face_;
  const SizeField& sizes_;
  Vec2 scale_{1, 1};
  bool smooth_;
};

/// Triangle quality 4√3·A/Σl² in space, times the cosine of the largest angle between the triangle's normal and the
/// surface's at its corners: 1 when equilateral and tangent, 0 when flat, negative when it faces away from the surface.
/// The cosine matters only where the size is large against the radius of curvature; there it keeps triangles from
/// cutting through the shape.
inline double signed_quality(const PatchPlace& a, const PatchPlace& b, const PatchPlace& c) {
  const Vec3 ab = b.point - a.point, ac = c.point - a.point, bc = c.point - b.point;
  const Vec3 n = cross(ab, ac);
  const double squares = norm2(ab) + norm2(ac) + norm2(bc), length = norm(n);
  if (!(squares > 0) || !(length > 0)) return 0;
  double cosine = 1;
  for (const PatchPlace* corner : {&a, &b, &c})
    if (corner->normal != Vec3{}) cosine = std::min(cosine, dot(n, corner->normal) / length);
  return 3.4641016151377544 * length / squares * cosine;
}

}  // namespace tetloom
