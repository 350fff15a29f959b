#include "mesher/parts/shell_tets.hpp"

#include "core/predicates/predicates.hpp"
#include "mesher/tets/triangle_verts.hpp"

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

std::optional<bool> is_inside_by_faces(const SharedInput& input, const TetMesh& mesh, std::uint32_t tet,
                                       const KnownTriangles& known) {
  for (FaceCode face = tet * 4; face < tet * 4 + 4; ++face) {
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
