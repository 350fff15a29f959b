#include "core/tets/link_tets.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#include "core/base/grain.hpp"
#include "core/predicates/predicates.hpp"
#include "core/tets/face_groups.hpp"
#include "core/tets/find_triangles.hpp"

namespace tetloom::tets {

namespace {

// Of the first tet without volume.
Fault turn_tets(TetMesh& mesh, const BlockLoop& loop) {
  const auto flat =
      map_blocks(loop, mesh.size(), kElementGrain, kNone, [&](std::size_t begin, std::size_t end, auto& first) {
        for (auto tet = static_cast<std::uint32_t>(begin); tet < end; ++tet) {
          const int sign =
              orient3d(mesh.point_of(tet, 0), mesh.point_of(tet, 1), mesh.point_of(tet, 2), mesh.point_of(tet, 3));
          if (sign == 0) first = std::min(first, tet);
          if (sign < 0) std::swap(mesh.to_vert[std::size_t{tet} * 4 + 2], mesh.to_vert[std::size_t{tet} * 4 + 3]);
        }
      });
  for (const std::uint32_t tet : flat)
    if (tet != kNone) return {"a tetrahedron has no volume", {}, mesh.point_of(tet, 0)};
  return {};
}

// The fault at the lowest face, of those that several tasks tell.
class LowestFault {
 public:
  void tell(FaceCode face, const char* message) {
    const std::lock_guard lock(mutex_);
    if (face < face_) face_ = face, message_ = message;
  }
  Fault fault(const TetMesh& mesh) const {
    if (!face_.valid()) return {};
    return {message_, {}, mesh.points[sorted(verts_of(mesh, face_)).verts[0]]};
  }

 private:
  std::mutex mutex_;
  FaceCode face_;
  const char* message_ = nullptr;
};

// Fills `tri_to_face` with the lowest face that each triangle is, but for repeated ones.
Fault link_faces(TetMesh& mesh, const TriangleIndex& triangles, std::span<FaceCode> tri_to_face,
                 const BlockLoop& loop) {
  LowestFault lowest;
  const auto link = [&](std::span<const FaceCode> faces, const TriangleVerts& verts) {
    if (const auto* triangle = triangles.find({verts})) tri_to_face[triangle->triangle] = faces[0];
    if (faces.size() == 1) return;
    if (sorted(verts_of(mesh, faces[0])).turned == sorted(verts_of(mesh, faces[1])).turned)
      return lowest.tell(faces[1], "two tetrahedra lie on one side of a face");
    if (faces.size() > 2) return lowest.tell(faces[2], "more than two tetrahedra share a face");
    link_sides(mesh, faces[0], faces[1]);
  };
  for_each_face_group(mesh.to_vert.span(), mesh.points.size(), loop, link);
  return lowest.fault(mesh);
}

Fault fix_surface(TetMesh& mesh, std::span<const TriangleVerts> triangles, const TriangleIndex& index,
                  std::span<const FaceCode> tri_to_face) {
  Fault fault;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const FaceCode face = tri_to_face[index.find(sorted(triangles[t]))->triangle];
    if (!face.valid()) {
      fault.triangles.push_back(t);
    } else {
      link_sides(mesh, face, mesh.behind(face), true);
    }
  }
  if (fault.triangles.empty()) return fault;
  const auto& [a, b, c] = triangles[fault.triangles[0]];
  fault.point = (mesh.points[a] + mesh.points[b] + mesh.points[c]) / 3;
  fault.message = std::to_string(fault.triangles.size()) + " surface triangles are not faces of the mesh";
  return fault;
}

}  // namespace

Fault link_tets(TetMesh& mesh, std::span<const std::array<std::uint32_t, 4>> tet_to_vert,
                std::span<const TriangleVerts> triangles, const BlockLoop& loop) {
  mesh.to_vert.reserve(tet_to_vert.size() * 4);
  for (const auto& tet : tet_to_vert) mesh.to_vert.append(std::span<const std::uint32_t>(tet));
  mesh.to_neighbor.resize(tet_to_vert.size() * 4);
  mesh.to_region.resize(tet_to_vert.size(), kNone);
  mesh.to_fixed.resize(tet_to_vert.size(), 0);
  if (Fault fault = turn_tets(mesh, loop); fault.any()) return fault;
  const TriangleIndex index(triangles, mesh.points.size());
  std::vector<FaceCode> tri_to_face(triangles.size());
  if (Fault fault = link_faces(mesh, index, tri_to_face, loop); fault.any()) return fault;
  return fix_surface(mesh, triangles, index, tri_to_face);
}

}  // namespace tetloom::tets
