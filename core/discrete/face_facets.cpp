#include "core/discrete/face_facets.hpp"

#include "core/base/disjoint_sets.hpp"

namespace tetloom::detail {
namespace {

// A point of the surface on the rim of a face.
void place_on_rim(std::uint32_t global, const Segmentation& segmentation, const PlacesOnEdges& on_edges,
                  ModelEntity& entity, double& parameter) {
  const std::uint32_t model_vert = segmentation.vert_to_model_vert[global];
  entity = ModelVertexId(model_vert);
  if (model_vert != kNone) return;
  entity = ModelEdgeId(on_edges.vert_to_model_edge[global]);
  parameter = on_edges.vert_to_parameter[global];
}

}  // namespace

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
                  const PlacesOnEdges& on_edges, std::uint32_t face, FaceFacets& result) {
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
  std::vector<std::uint32_t> vert_to_global;
  std::vector<bool> on_rim;
  result.tri_to_vert.resize(count);
  for (std::uint32_t local = 0; local < 3 * count; ++local) {
    const std::uint32_t root = corners.find(local);  // the lowest corner of the fan, met first
    if (root == local) {
      corner_to_vert[local] = static_cast<std::uint32_t>(result.points.size());
      vert_to_global.push_back(surface.tri_to_vert[tris[local / 3]][local % 3]);
      result.points.push_back(surface.points[vert_to_global.back()]);
      result.vert_to_corner.push_back(local);
      on_rim.push_back(false);
    }
    const std::uint32_t vert = corner_to_vert[root];
    result.tri_to_vert[local / 3][local % 3] = vert;
    if (corner_on_rim[local]) on_rim[vert] = true;
  }
  result.vert_to_entity.assign(vert_to_global.size(), ModelFaceId(face));
  result.vert_to_parameter.assign(vert_to_global.size(), 0);
  for (std::size_t v = 0; v < vert_to_global.size(); ++v)
    if (on_rim[v])
      place_on_rim(vert_to_global[v], segmentation, on_edges, result.vert_to_entity[v], result.vert_to_parameter[v]);
  result.jets = fit_jets(result.points, result.tri_to_vert, on_rim);
  result.bvh = FacetBvh(result.points, result.tri_to_vert);
}

void put_facets(MessageWriter& writer, const FaceFacets& facets) {
  writer.put_array<Vec3>(facets.points);
  writer.put_array<Triangle>(facets.tri_to_vert);
  writer.put_array<std::uint32_t>(facets.vert_to_corner);
  writer.put_array<ModelEntity>(facets.vert_to_entity);
  writer.put_array<double>(facets.vert_to_parameter);
  writer.put_array<Vec3>(facets.jets.normals);
  writer.put_array<SymmetricTensor>(facets.jets.bending);
}

void get_facets(MessageReader& reader, FaceFacets& facets) {
  facets.points = reader.get_array<Vec3>();
  facets.tri_to_vert = reader.get_array<Triangle>();
  facets.vert_to_corner = reader.get_array<std::uint32_t>();
  facets.vert_to_entity = reader.get_array<ModelEntity>();
  facets.vert_to_parameter = reader.get_array<double>();
  facets.jets.normals = reader.get_array<Vec3>();
  facets.jets.bending = reader.get_array<SymmetricTensor>();
  facets.bvh = FacetBvh(facets.points, facets.tri_to_vert);
}

}  // namespace tetloom::detail
