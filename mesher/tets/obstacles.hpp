#pragma once
// What lies in the way of an edge or a triangle of the surface.
#include "core/tets/local_mesh.hpp"
#include "mesher/tets/recovery.hpp"

namespace tetloom::tets {

/// The tets to be replaced, or why they cannot be.
struct Obstacles {
  TetList tets;
  RecoveryFault fault = RecoveryFault::NotRecovered;
  bool blocked = false;
  Vec3 point;     ///< where it is blocked
  FaceCode face;  ///< the fixed face that blocks it

  void block(RecoveryFault why, const Vec3& where, FaceCode by = {}) {
    fault = why;
    blocked = true;
    point = where;
    face = by;
  }
};

/// The tets that the open segment ab meets. Blocked by a fixed face and by a point in the way. Pre: no edge of the
/// mesh.
Obstacles find_obstacles(const LocalMesh& mesh, std::uint32_t a, std::uint32_t b);

/// The tets with an edge that meets the inside of the triangle. Blocked likewise. Pre: no face of the mesh, but its
/// edges are edges of the mesh.
Obstacles find_obstacles(const LocalMesh& mesh, const TriangleVerts& triangle);

/// Whether x lies on the open segment ab. Exact.
bool lies_between(const Vec3& x, const Vec3& a, const Vec3& b);
bool collinear(const Vec3& a, const Vec3& b, const Vec3& c);

/// segment_meets_triangle with the points of the mesh.
bool meets(const LocalMesh& mesh, std::uint32_t p, std::uint32_t q, const TriangleVerts& t);

}  // namespace tetloom::tets
