#include "core/tets/tet_mesh.hpp"

#include <algorithm>
#include <array>

#include "core/predicates/predicates.hpp"
#include "core/tets/many_values.hpp"

namespace tetloom::tets {

namespace {

void move_tet(TetMesh& mesh, std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t i = 0; i < 4; ++i) {
    mesh.to_vert[std::size_t{to} * 4 + i] = mesh.to_vert[std::size_t{from} * 4 + i];
    const FaceCode neighbor = mesh.behind({from, i});
    mesh.behind({to, i}) = neighbor;
    if (neighbor.valid()) mesh.behind(neighbor) = {to, i};
  }
  mesh.to_region[to] = mesh.to_region[from];
  mesh.to_fixed[to] = mesh.to_fixed[from];
}

std::string name_of(std::uint32_t tet) { return "tet " + std::to_string(tet); }

std::string find_face_fault(const TetMesh& mesh, std::uint32_t tet, std::uint32_t i) {
  const FaceCode face(tet, i), back = mesh.behind(face);
  if (!back.valid()) return {};
  if (back.index() >= mesh.to_neighbor.size() || mesh.is_dead(back.tet()))
    return name_of(tet) + " has a neighbour that is not";
  if (mesh.behind(back) != face) return name_of(tet) + " is not the neighbour of its neighbour";
  if (mesh.is_fixed(face) != mesh.is_fixed(back)) return name_of(tet) + " has a face fixed on one side only";
  if (mesh.to_region[tet] != mesh.to_region[back.tet()] && !mesh.is_fixed(face))
    return name_of(tet) + " has a face between regions that is not fixed";
  std::array<std::uint32_t, 3> mine, theirs;
  for (std::size_t k = 0; k < 3; ++k) {
    mine[k] = mesh.to_vert[std::size_t{tet} * 4 + kFaceVerts[i][k]];
    theirs[k] = mesh.to_vert[std::size_t{back.tet()} * 4 + kFaceVerts[back.side()][k]];
  }
  std::sort(mine.begin(), mine.end());
  std::sort(theirs.begin(), theirs.end());
  return mine == theirs ? std::string() : name_of(tet) + " has a neighbour with another face";
}

}  // namespace

void compact(TetMesh& mesh, std::span<const std::uint32_t> dead) {
  const std::size_t count =
      fill_holes(mesh.size(), dead, [&mesh](std::uint32_t from, std::uint32_t to) { move_tet(mesh, from, to); });
  mesh.to_vert.resize(count * 4);
  mesh.to_neighbor.resize(count * 4);
  mesh.to_region.resize(count);
  mesh.to_fixed.resize(count);
}

void compact(TetMesh& mesh) {
  std::vector<std::uint32_t> dead;
  const std::uint32_t* verts = mesh.to_vert.data();
  for_each_that(
      0, mesh.size(), [verts](std::size_t tet) { return verts[tet * 4] == kNone; },
      [&](std::size_t tet) { dead.push_back(static_cast<std::uint32_t>(tet)); });
  compact(mesh, dead);
}

std::string find_fault(const TetMesh& mesh) {
  if (mesh.to_vert.size() != mesh.size() * 4 || mesh.to_neighbor.size() != mesh.size() * 4 ||
      mesh.to_region.size() != mesh.size())
    return "arrays differ in length";
  for (std::uint32_t tet = 0; tet < mesh.size(); ++tet) {
    if (mesh.is_dead(tet)) continue;
    for (std::uint32_t i = 0; i < 4; ++i) {
      if (mesh.to_vert[std::size_t{tet} * 4 + i] >= mesh.points.size())
        return name_of(tet) + " has a vertex that is not";
      if (std::string fault = find_face_fault(mesh, tet, i); !fault.empty()) return fault;
    }
    if (orient3d(mesh.point_of(tet, 0), mesh.point_of(tet, 1), mesh.point_of(tet, 2), mesh.point_of(tet, 3)) <= 0)
      return name_of(tet) + " has no positive volume";
  }
  return {};
}

}  // namespace tetloom::tets
