// Which triangles are faces of the mesh: one pass over the tets, asking for faces of three surface points.
#include "core/tets/find_triangles.hpp"

#include <algorithm>

namespace tetloom::tets {

namespace {

constexpr std::size_t kBlock = 1 << 16;

bool are_below(const TriangleVerts& t, std::size_t count) {
  return std::all_of(t.begin(), t.end(), [count](std::uint32_t v) { return v < count; });
}

std::vector<std::uint8_t> mark_points(std::size_t count, std::span<const TriangleVerts> triangles) {
  std::vector<std::uint8_t> marks(count, 0);
  for (const TriangleVerts& t : triangles) {
    if (!are_below(t, count)) continue;
    for (const std::uint32_t v : t) marks[v] = 1;
  }
  return marks;
}

}  // namespace

TriangleIndex::TriangleIndex(std::span<const TriangleVerts> triangles, std::size_t point_count)
    : vert_to_end_(point_count + 1, 0) {
  for (const TriangleVerts& t : triangles) {
    if (are_below(t, point_count)) ++vert_to_end_[std::min({t[0], t[1], t[2]}) + 1];
  }
  for (std::size_t v = 0; v < point_count; ++v) vert_to_end_[v + 1] += vert_to_end_[v];
  entries_.resize(vert_to_end_[point_count]);
  // Each place still holds the begin of its vertex and runs to the end.
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (!are_below(triangles[i], point_count)) continue;
    const SortedTriangle key = sorted(triangles[i]);
    entries_[vert_to_end_[key.verts[0]]++] = {key.verts[1], key.verts[2], i, key.turned};
  }
}

TrianglesByVertex::TrianglesByVertex(std::span<const TriangleVerts> triangles, std::size_t point_count)
    : triangles_(triangles), by_vertex_(triangles.size()), vert_to_end_(point_count + 1, 0) {
  for (const TriangleVerts& t : triangles) ++vert_to_end_[std::min({t[0], t[1], t[2]}) + 1];
  for (std::size_t v = 0; v < point_count; ++v) vert_to_end_[v + 1] += vert_to_end_[v];
  // Each place still holds the begin of its vertex and runs to the end.
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const auto& [a, b, c] = triangles[i];
    by_vertex_[vert_to_end_[std::min({a, b, c})]++] = i;
  }
}

std::optional<std::uint32_t> TrianglesByVertex::find(const SortedTriangle& key) const {
  const std::uint32_t lowest = key.verts[0];
  for (std::uint32_t i = lowest == 0 ? 0 : vert_to_end_[lowest - 1]; i < vert_to_end_[lowest]; ++i)
    if (sorted(triangles_[by_vertex_[i]]).verts == key.verts) return by_vertex_[i];
  return std::nullopt;
}

std::vector<FaceCode> find_triangles(const TetMesh& mesh, std::span<const TriangleVerts> triangles,
                                     const TriangleIndex& index, const BlockLoop& loop) {
  std::vector<FaceCode> result(triangles.size());
  const std::vector<std::uint8_t> marks = mark_points(mesh.points.size(), triangles);
  loop.for_blocks(mesh.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      if (mesh.is_dead(static_cast<std::uint32_t>(tet))) continue;
      const std::uint32_t* v = mesh.to_vert.data() + tet * 4;
      const int on_surface = marks[v[0]] + marks[v[1]] + marks[v[2]] + marks[v[3]];
      if (on_surface < 3) continue;
      for (std::uint32_t i = 0; i < 4; ++i) {
        const FaceCode code(tet, i);
        const FaceCode back = mesh.behind(code);
        // Each face once, so that no two tasks write the same place. The hull is no surface.
        if (!back.valid() || back < code || (on_surface == 3 && marks[v[i]] != 0)) continue;
        const auto& f = kFaceVerts[i];
        const SortedTriangle key = sorted({v[f[0]], v[f[2]], v[f[1]]});  // as seen from inside
        if (const TriangleIndex::Entry* entry = index.find(key))
          result[entry->triangle] = key.turned == entry->turned ? code : back;
      }
    }
  });
  return result;
}

std::vector<FaceCode> find_triangles(const TetMesh& mesh, std::span<const TriangleVerts> triangles,
                                     const BlockLoop& loop) {
  const TriangleIndex index(triangles, mesh.points.size());
  std::vector<FaceCode> result = find_triangles(mesh, triangles, index, loop);
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (!are_below(triangles[i], mesh.points.size())) continue;
    const SortedTriangle key = sorted(triangles[i]);
    const TriangleIndex::Entry& first = *index.find(key);
    if (first.triangle != i && result[first.triangle].valid())
      result[i] = key.turned == first.turned ? result[first.triangle] : mesh.behind(result[first.triangle]);
  }
  return result;
}

std::vector<std::uint32_t> fix_triangles(TetMesh& mesh, std::span<const TriangleVerts> triangles,
                                         const TriangleIndex& index, const BlockLoop& loop) {
  const std::vector<FaceCode> tri_to_face = find_triangles(mesh, triangles, index, loop);
  std::vector<std::uint32_t> missing;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (!tri_to_face[i].valid()) {
      missing.push_back(i);
      continue;
    }
    for (const FaceCode face : {tri_to_face[i], mesh.behind(tri_to_face[i])}) fix_side(mesh, face);
  }
  return missing;
}

}  // namespace tetloom::tets
