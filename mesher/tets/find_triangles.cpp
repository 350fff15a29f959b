// Which triangles are faces of the mesh: one pass over the tets, asking a table for faces of three surface points.
#include "mesher/tets/find_triangles.hpp"

namespace tetloom::tets {

namespace {

constexpr std::size_t kBlock = 1 << 16;

std::vector<std::uint8_t> mark_points(std::size_t count, std::span<const TriangleVerts> triangles) {
  std::vector<std::uint8_t> marks(count, 0);
  for (const TriangleVerts& t : triangles) {
    for (const std::uint32_t v : t) {
      if (v < count) marks[v] = 1;
    }
  }
  return marks;
}

// Calls visit(face, triangle, whether the tet is on its front side) for every face that is a triangle.
template <class Visit>
void visit_faces(const TetMesh& mesh, std::span<const std::uint8_t> marks, const TriangleTable& table,
                 const TaskRunner& runner, const Visit& visit) {
  runner.for_blocks(mesh.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      if (mesh.is_dead(static_cast<std::uint32_t>(tet))) continue;
      const std::uint32_t* v = mesh.to_vert.data() + tet * 4;
      const int on_surface = marks[v[0]] + marks[v[1]] + marks[v[2]] + marks[v[3]];
      if (on_surface < 3) continue;
      for (std::uint32_t i = 0; i < 4; ++i) {
        if (on_surface == 3 && marks[v[i]] != 0) continue;
        const TriangleVerts inner_face{v[kFaceVerts[i][0]], v[kFaceVerts[i][2]], v[kFaceVerts[i][1]]};
        const SortedTriangle key = sorted(inner_face);
        if (const TriangleTable::Entry* entry = table.find(key))
          visit(static_cast<FaceCode>(tet * 4 + i), entry->value, key.turned == entry->turned);
      }
    }
  });
}

}  // namespace

TriangleTable make_table(std::span<const TriangleVerts> triangles) {
  TriangleTable table(triangles.size());
  for (std::uint32_t i = 0; i < triangles.size(); ++i) table.add(triangles[i], i);
  return table;
}

std::vector<FaceCode> find_triangles(const TetMesh& mesh, std::span<const TriangleVerts> triangles,
                                     const TaskRunner& runner) {
  std::vector<FaceCode> result(triangles.size(), kNone);
  const TriangleTable table = make_table(triangles);
  visit_faces(mesh, mark_points(mesh.points.size(), triangles), table, runner,
              [&](FaceCode code, std::uint32_t triangle, bool in_front) {
                if (in_front) result[triangle] = code;
              });
  for (std::size_t i = 0; i < triangles.size(); ++i) {  // repeated ones
    const SortedTriangle key = sorted(triangles[i]);
    const TriangleTable::Entry& first = *table.find(key);
    if (first.value != i && result[first.value] != kNone)
      result[i] = key.turned == first.turned ? result[first.value] : mesh.to_neighbor[result[first.value]];
  }
  return result;
}

std::vector<std::uint32_t> fix_triangles(TetMesh& mesh, std::span<const TriangleVerts> triangles,
                                         const TriangleTable& table, const TaskRunner& runner) {
  std::vector<std::uint8_t> found(triangles.size(), 0);
  visit_faces(mesh, mark_points(mesh.points.size(), triangles), table, runner,
              [&](FaceCode code, std::uint32_t triangle, bool in_front) {
                // Each tet belongs to one task; each triangle has one tet on its front side.
                mesh.to_fixed[code / 4] = static_cast<std::uint8_t>(mesh.to_fixed[code / 4] | 1u << code % 4);
                if (in_front) found[triangle] = 1;
              });
  std::vector<std::uint32_t> missing;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (found[i] == 0) missing.push_back(i);
  }
  return missing;
}

}  // namespace tetloom::tets
