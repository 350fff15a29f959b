#include "mesher/parts/shell_tets.hpp"

#include "core/predicates/predicates.hpp"
#include "core/tets/triangle_verts.hpp"

namespace tetloom::parts {

using tets::FaceCode;
using tets::TetMesh;

Vec3 center_of(const TetMesh& mesh, std::uint32_t tet) {
  return 0.25 * (mesh.point_of(tet, 0) + mesh.point_of(tet, 1) + mesh.point_of(tet, 2) + mesh.point_of(tet, 3));
}

bool ball_holds(const TetMesh& mesh, std::uint32_t tet, const Vec3& point) {
  return insphere(mesh.point_of(tet, 0), mesh.point_of(tet, 1), mesh.point_of(tet, 2), mesh.point_of(tet, 3), point) >
         0;
}

TetBall::TetBall(const TetMesh& mesh, std::uint32_t tet) : mesh_(mesh), tet_(tet) {
  constexpr double kFlat = 1e-3;  // volume beside that of a box with the same edges: rounding is nothing from here on
  const Vec3& a = mesh.point_of(tet, 0);
  const Vec3 p = mesh.point_of(tet, 1) - a, q = mesh.point_of(tet, 2) - a, r = mesh.point_of(tet, 3) - a;
  const Vec3 qr = cross(q, r);
  const double volume = dot(p, qr), pp = norm2(p), qq = norm2(q), rr = norm2(r);
  if (!(volume * volume > kFlat * kFlat * pp * qq * rr)) return;
  const Vec3 center = (pp * qr + qq * cross(r, p) + rr * cross(p, q)) / (2 * volume);
  center_ = a + center;
  radius_ = norm(center);
}

bool TetBall::holds(const lattice::SiteLattice& lattice, const lattice::Site& site) const {
  constexpr double kMargin = 1e-6;
  if (radius_ >= 0) {
    const double distance2 = norm2(lattice.place(site) - center_);
    const double least = radius_ * (1 - kMargin) - 2 * lattice.most_moved();  // moved along three axes
    if (least > 0 && distance2 < least * least) return true;
    const double most = radius_ * (1 + kMargin) + 2 * lattice.most_moved();
    if (distance2 > most * most) return false;
  }
  return ball_holds(mesh_, tet_, lattice.point(site));
}

std::optional<bool> is_inside_by_faces(const SharedInput& input, const TetMesh& mesh, std::uint32_t tet,
                                       const ComplexTriangles& known) {
  for (const FaceCode face : FaceCode::of(tet)) {
    if (!mesh.is_fixed(face)) continue;
    const tets::SortedTriangle key = tets::sorted(verts_of(mesh, face));
    const auto* triangle = known.index.find(key);
    if (!triangle) continue;
    const FaceSides& sides = input.filling.complex.tri_to_sides[known.triangles[triangle->triangle]];
    return (key.turned == triangle->turned ? sides.back : sides.front).valid();
  }
  return std::nullopt;
}

bool is_inside_by_center(const SharedInput& input, const TetMesh& mesh, std::uint32_t tet) {
  return input.cells.is_inside(center_of(mesh, tet));
}

}  // namespace tetloom::parts
