#include "core/mesh/incidence_detail.hpp"

namespace tetloom::detail {

std::vector<Window> cut_windows(std::span<const std::uint32_t> counts, std::size_t limit) {
  std::vector<Window> windows;
  Window open;
  for (std::uint32_t key = 0; key < counts.size(); ++key) {
    if (open.uses > 0 && open.uses + counts[key] > limit) {
      windows.push_back(open);
      open = {key, key, 0};
    }
    open.last = key + 1;
    open.uses += counts[key];
  }
  if (open.uses > 0) windows.push_back(open);
  return windows;
}

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
