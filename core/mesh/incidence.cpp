#include "core/mesh/incidence_detail.hpp"

namespace tetloom::detail {

FacePoints points_of(const Mesh& mesh, const FaceUse& use) {
  if (use.owner() == FaceOwner::Quad) return {4, mesh.quad_to_vert[use.element()]};
  if (use.owner() == FaceOwner::Triangle) {
    const auto [a, b, c] = mesh.tri_to_vert[use.element()];
    return {3, {a, b, c, 0}};
  }
  const LocalFace& face = shape_of(use.cell().kind).faces()[static_cast<std::size_t>(use.local_face())];
  const std::span<const std::uint32_t> vertices = vertices_of(mesh, use.cell());
  FacePoints points{face.count, {}};
  for (std::size_t i = 0; i < face.count; ++i) points.cycle[i] = vertices[face.vert[i]];
  return points;
}

}  // namespace tetloom::detail
