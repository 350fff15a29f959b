#include "mesher/tets/surface_triangles.hpp"

#include "core/base/lists.hpp"

namespace tetloom::tets {

namespace {

// The vertex after a -> b, or kNone when the triangle does not run that way.
std::uint32_t apex_after(const TriangleVerts& verts, std::uint32_t a, std::uint32_t b) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (verts[i] == a && verts[(i + 1) % 3] == b) return verts[(i + 2) % 3];
  }
  return kNone;
}

}  // namespace

SurfaceTriangles::SurfaceTriangles(std::span<TriangleVerts> tri_to_vert, std::size_t point_count)
    : tri_to_vert_(tri_to_vert), first_(point_count, kNone), next_(tri_to_vert.size() * 3, kNone) {
  for (std::uint32_t triangle = 0; triangle < tri_to_vert.size(); ++triangle) add(triangle, tri_to_vert[triangle]);
}

void SurfaceTriangles::add(std::uint32_t triangle, const TriangleVerts& verts) {
  tri_to_vert_[triangle] = verts;
  for (std::uint32_t i = 0; i < 3; ++i) {
    next_[triangle * 3 + i] = first_[verts[i]];
    first_[verts[i]] = triangle * 3 + i;
  }
}

void SurfaceTriangles::remove(std::uint32_t triangle) {
  for (std::uint32_t i = 0; i < 3; ++i) {
    std::uint32_t* link = &first_[tri_to_vert_[triangle][i]];
    while (*link != triangle * 3 + i) link = &next_[*link];
    *link = next_[*link];
  }
}

bool SurfaceTriangles::has_edge(std::uint32_t a, std::uint32_t b) const {
  bool found = false;
  for_each_at(a, [&](std::uint32_t triangle) { found = found || has(tri_to_vert_[triangle], b); });
  return found;
}

bool SurfaceTriangles::find_diamond(std::uint32_t a, std::uint32_t b, Diamond& diamond) const {
  diamond = {kNone, kNone, a, b, kNone, kNone};
  int count = 0;
  for_each_at(a, [&](std::uint32_t triangle) {
    const TriangleVerts& verts = tri_to_vert_[triangle];
    if (!has(verts, b)) return;
    ++count;
    if (const std::uint32_t p = apex_after(verts, a, b); p != kNone) diamond.left = triangle, diamond.p = p;
    if (const std::uint32_t q = apex_after(verts, b, a); q != kNone) diamond.right = triangle, diamond.q = q;
  });
  return count == 2 && diamond.left != kNone && diamond.right != kNone && diamond.p != diamond.q;
}

void SurfaceTriangles::swap(const Diamond& diamond) {
  remove(diamond.left);
  remove(diamond.right);
  add(diamond.left, diamond.after()[0]);
  add(diamond.right, diamond.after()[1]);
}

}  // namespace tetloom::tets
