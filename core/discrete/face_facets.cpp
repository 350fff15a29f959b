#include "core/discrete/face_facets.hpp"

#include "core/base/disjoint_sets.hpp"

namespace tetloom::detail {

FaceMembers list_members(const Segmentation& segmentation) {
  FaceMembers members;
  const auto& tri_to_face = segmentation.tri_to_face;
  members.offset.assign(segmentation.face_count + 1, 0);
  for (const std::uint32_t face : tri_to_face) ++members.offset[face + 1];
  for (std::uint32_t face = 0; face < segmentation.face_count; ++face) members.offset[face + 1] += members.offset[face];
  members.tris.resize(tri_to_face.size()), members.tri_to_position.resize(tri_to_face.size());
  std::vector<std::uint32_t> fill(members.offset.begin(), members.offset.end() - 1);
  for (std::uint32_t tri = 0; tri < tri_to_face.size(); ++tri) {
    const std::uint32_t face = tri_to_face[tri], slot = fill[face]++;
    members.tris[slot] = tri, members.tri_to_position[tri] = slot - members.offset[face];
  }
  return members;
}

void collect_face(const FacetSurface& surface, const Segmentation& segmentation, const FaceMembers& members,
                  std::uint32_t face, FaceFacets& result) {
  const auto tris = members.of(face);
  const auto count = static_cast<std::uint32_t>(tris.size());
  DisjointSets corners(3 * std::size_t{count});
  std::vector<bool> corner_on_rim(3 * std::size_t{count}, false);
  for (std::uint32_t local = 0; local < 3 * count; ++local) {
    const std::uint32_t half = 3 * tris[local / 3] + local % 3;
    if (segmentation.edge_to_model_edge[surface.edges.half_to_edge[half]] != kNone) {
      corner_on_rim[local] = corner_on_rim[next_half(local)] = true;
      continue;
    }
    const std::uint32_t twin = surface.edges.twin(half);
    const std::uint32_t local_twin = 3 * members.tri_to_position[half_to_tri(twin)] + twin % 3;
    corners.join(local, next_half(local_twin));
  }
  std::vector<std::uint32_t> corner_to_vert(3 * std::size_t{count}, kNone);
  result.tri_to_vert.resize(count);
  for (std::uint32_t local = 0; local < 3 * count; ++local) {
    const std::uint32_t root = corners.find(local);  // the lowest corner of the fan, met first
    if (root == local) {
      corner_to_vert[local] = static_cast<std::uint32_t>(result.points.size());
      result.vert_to_global.push_back(surface.tri_to_vert[tris[local / 3]][local % 3]);
      result.points.push_back(surface.points[result.vert_to_global.back()]);
      result.vert_to_corner.push_back(local);
      result.on_rim.push_back(false);
    }
    const std::uint32_t vert = corner_to_vert[root];
    result.tri_to_vert[local / 3][local % 3] = vert;
    if (corner_on_rim[local]) result.on_rim[vert] = true;
  }
  result.jets = fit_jets(result.points, result.tri_to_vert, result.on_rim);
  result.bvh = FacetBvh(result.points, result.tri_to_vert);
}

}  // namespace tetloom::detail
