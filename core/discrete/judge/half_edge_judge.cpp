#include "core/discrete/judge/half_edge_judge.hpp"

#include <OpenMesh/Core/IO/MeshIO.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <vector>

namespace tetloom {
namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

HalfEdgeCounts count(const HalfEdgeMesh& mesh) {
  HalfEdgeCounts counts{mesh.n_vertices(), mesh.n_edges(), mesh.n_faces(), 0};
  for (const auto edge : mesh.edges()) counts.open_edges += mesh.is_boundary(edge);
  return counts;
}

}  // namespace

std::optional<HalfEdgeCounts> judge_facets(std::span<const Vec3> points,
                                           std::span<const std::array<std::uint32_t, 3>> tri_to_vert) {
  HalfEdgeMesh mesh;
  std::vector<HalfEdgeMesh::VertexHandle> handles;
  for (const Vec3& p : points) handles.push_back(mesh.add_vertex({p.x, p.y, p.z}));
  for (const auto& [a, b, c] : tri_to_vert) {
    if (!mesh.add_face(handles[a], handles[b], handles[c]).is_valid()) return std::nullopt;
  }
  return count(mesh);
}

std::optional<HalfEdgeCounts> judge_file(const std::filesystem::path& path) {
  HalfEdgeMesh mesh;
  if (!OpenMesh::IO::read_mesh(mesh, path.string())) return std::nullopt;
  return count(mesh);
}

}  // namespace tetloom
