#include "mesher/tets/link_tets.hpp"

#include <utility>

#include "core/predicates/predicates.hpp"
#include "mesher/tets/find_triangles.hpp"

namespace tetloom::tets {

namespace {

constexpr std::uint32_t kBetweenChecks = 1 << 14;  // tets or faces between two looks at the cancellation

Fault turn_tets(TetMesh& mesh, const TaskRunner& runner) {
  for (std::uint32_t tet = 0; tet < mesh.size(); ++tet) {
    if (tet % kBetweenChecks == 0) runner.check_cancelled();
    const Vec3& a = mesh.point_of(tet, 0);
    const int sign = orient3d(a, mesh.point_of(tet, 1), mesh.point_of(tet, 2), mesh.point_of(tet, 3));
    if (sign == 0) return {"a tetrahedron has no volume", {}, a};
    if (sign < 0) std::swap(mesh.to_vert[std::size_t{tet} * 4 + 2], mesh.to_vert[std::size_t{tet} * 4 + 3]);
  }
  return {};
}

std::vector<TriangleVerts> faces_of(const TetMesh& mesh) {
  std::vector<TriangleVerts> faces(mesh.to_neighbor.size());
  for (FaceCode face = 0; face < faces.size(); ++face) faces[face] = verts_of(mesh, face);
  return faces;
}

// Each face with the first one of the same vertices.
Fault link_faces(TetMesh& mesh, const TriangleIndex& faces, const TaskRunner& runner) {
  for (FaceCode face = 0; face < mesh.to_neighbor.size(); ++face) {
    if (face % kBetweenChecks == 0) runner.check_cancelled();
    const SortedTriangle key = sorted(verts_of(mesh, face));
    const TriangleIndex::Entry& first = *faces.find(key);
    if (first.triangle == face) continue;
    const Vec3& point = mesh.points[key.verts[0]];
    if (mesh.to_neighbor[first.triangle] != kNone) return {"more than two tetrahedra share a face", {}, point};
    if (first.turned == key.turned) return {"two tetrahedra lie on one side of a face", {}, point};
    mesh.to_neighbor[face] = first.triangle;
    mesh.to_neighbor[first.triangle] = face;
  }
  return {};
}

void fix(TetMesh& mesh, FaceCode face) {
  mesh.to_fixed[face / 4] = static_cast<std::uint8_t>(mesh.to_fixed[face / 4] | 1u << face % 4);
}

Fault fix_surface(TetMesh& mesh, std::span<const TriangleVerts> triangles, const TriangleIndex& faces) {
  Fault fault;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const TriangleIndex::Entry* found = faces.find(sorted(triangles[t]));
    if (!found) {
      fault.triangles.push_back(t);
      continue;
    }
    fix(mesh, found->triangle);
    if (const FaceCode behind = mesh.to_neighbor[found->triangle]; behind != kNone) fix(mesh, behind);
  }
  if (fault.triangles.empty()) return fault;
  const auto& [a, b, c] = triangles[fault.triangles[0]];
  fault.point = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3;
  fault.message = std::to_string(fault.triangles.size()) + " surface triangles are not faces of the mesh";
  return fault;
}

}  // namespace

Fault link_tets(TetMesh& mesh, std::span<const std::array<std::uint32_t, 4>> tet_to_vert,
                std::span<const TriangleVerts> triangles, const TaskRunner& runner) {
  mesh.to_vert.reserve(tet_to_vert.size() * 4);
  for (const auto& tet : tet_to_vert) mesh.to_vert.append(std::span<const std::uint32_t>(tet));
  mesh.to_neighbor.resize(tet_to_vert.size() * 4, kNone);
  mesh.to_region.resize(tet_to_vert.size(), kNone);
  mesh.to_fixed.resize(tet_to_vert.size(), 0);
  if (Fault fault = turn_tets(mesh, runner); fault.any()) return fault;
  const std::vector<TriangleVerts> verts = faces_of(mesh);
  const TriangleIndex faces(verts, mesh.points.size());
  if (Fault fault = link_faces(mesh, faces, runner); fault.any()) return fault;
  return fix_surface(mesh, triangles, faces);
}

}  // namespace tetloom::tets
