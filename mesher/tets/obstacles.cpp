#include "mesher/tets/obstacles.hpp"

#include <algorithm>
#include <unordered_set>

#include "mesher/tets/segment_triangle.hpp"

namespace tetloom::tets {

namespace {

constexpr std::size_t kTetsAtMost = 5000;

Vec3 center_of(const LocalMesh& mesh, const TriangleVerts& t) {
  return (mesh.point(t[0]) + mesh.point(t[1]) + mesh.point(t[2])) / 3;
}

// Floods from the tets in `found` through faces for which `passes(face)`; blocked where such a face is fixed.
template <class Passes>
void flood(const LocalMesh& mesh, const Passes& passes, Obstacles& found) {
  std::unordered_set<std::uint32_t> seen(found.tets.begin(), found.tets.end());
  for (std::size_t i = 0; i < found.tets.size() && found.tets.size() < kTetsAtMost; ++i) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const FaceCode code(found.tets[i], k), back = mesh.mesh().behind(code);
      if (back.valid() && seen.contains(back.tet())) {
        if (!mesh.mesh().is_fixed(code)) continue;
      }
      const TriangleVerts face = mesh.face(code);
      if (!passes(face)) continue;
      if (!back.valid() || mesh.mesh().is_fixed(code))
        return found.block(RecoveryFault::Crossed, center_of(mesh, face), code);
      seen.insert(back.tet());
      found.tets.push_back(back.tet());
    }
  }
}

// Whether the tet at a, seen from there, has b in its closed cone.
bool cone_holds(const LocalMesh& mesh, std::uint32_t tet, std::uint32_t a, std::uint32_t b) {
  const TriangleVerts f = mesh.face({tet, mesh.corner_of(tet, a)});
  const Vec3 &p = mesh.point(f[0]), &q = mesh.point(f[1]), &r = mesh.point(f[2]), &x = mesh.point(a),
             &y = mesh.point(b);
  return orient3d(y, q, r, x) >= 0 && orient3d(p, y, r, x) >= 0 && orient3d(p, q, y, x) >= 0;
}

}  // namespace

bool meets(const LocalMesh& mesh, std::uint32_t p, std::uint32_t q, const TriangleVerts& t) {
  const auto point = [&](std::uint32_t v) -> const Vec3& { return mesh.point(v); };
  const auto sign = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    return orient3d(point(a), point(b), point(c), point(d));
  };
  return segment_meets_triangle(sign, point, p, q, t);
}

bool collinear(const Vec3& a, const Vec3& b, const Vec3& c) {
  return orient2d({a.x, a.y}, {b.x, b.y}, {c.x, c.y}) == 0 && orient2d({a.y, a.z}, {b.y, b.z}, {c.y, c.z}) == 0 &&
         orient2d({a.z, a.x}, {b.z, b.x}, {c.z, c.x}) == 0;
}

bool lies_between(const Vec3& x, const Vec3& a, const Vec3& b) {
  if (!collinear(a, b, x)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (x[axis] < std::min(a[axis], b[axis]) || x[axis] > std::max(a[axis], b[axis])) return false;
  }
  return x != a && x != b;
}

Obstacles find_obstacles(const LocalMesh& mesh, std::uint32_t a, std::uint32_t b) {
  Obstacles found;
  for (const std::uint32_t t : mesh.find_ball(a)) {
    if (cone_holds(mesh, t, a, b)) found.tets.push_back(t);
  }
  flood(
      mesh, [&](const TriangleVerts& face) { return meets(mesh, a, b, face); }, found);
  for (const std::uint32_t t : found.tets) {
    for (const std::uint32_t v : mesh.tet(t)) {
      if (v != a && v != b && lies_between(mesh.point(v), mesh.point(a), mesh.point(b))) {
        found.block(RecoveryFault::PointInside, mesh.point(v));
        return found;
      }
    }
  }
  return found;
}

Obstacles find_obstacles(const LocalMesh& mesh, const TriangleVerts& triangle) {
  Obstacles found;
  const auto pierces = [&](std::uint32_t p, std::uint32_t q) { return meets(mesh, p, q, triangle); };
  for (std::size_t i = 0; i < 3; ++i) {
    for (const std::uint32_t t : mesh.find_shell(triangle[i], triangle[(i + 1) % 3])) {
      const Tet v = mesh.tet(t);
      bool pierced = false;
      for (std::size_t k = 0; k < 6 && !pierced; ++k) {
        pierced = pierces(v[kEdgeVerts[k][0]], v[kEdgeVerts[k][1]]);
      }
      if (pierced && std::find(found.tets.begin(), found.tets.end(), t) == found.tets.end()) found.tets.push_back(t);
    }
  }
  flood(
      mesh, [&](const TriangleVerts& f) { return pierces(f[0], f[1]) || pierces(f[1], f[2]) || pierces(f[2], f[0]); },
      found);
  const Vec3 &a = mesh.point(triangle[0]), &b = mesh.point(triangle[1]), &c = mesh.point(triangle[2]);
  const PlaneTurn turn(a, b, c);
  for (const std::uint32_t t : found.tets) {
    for (const std::uint32_t v : mesh.tet(t)) {
      const Vec3& p = mesh.point(v);
      if (v == triangle[0] || v == triangle[1] || v == triangle[2] || orient3d(a, b, c, p) != 0) continue;
      if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) {
        found.block(RecoveryFault::PointInside, p);
        return found;
      }
    }
  }
  return found;
}

}  // namespace tetloom::tets
