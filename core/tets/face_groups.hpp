#pragma once
// Which tetrahedra share a face, of tets of which only the vertices are known.
#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/grouping.hpp"
#include "core/tets/triangle_verts.hpp"
#include "tetloom/host.hpp"

namespace tetloom::tets {

/// Calls visit(faces, verts) for all faces that have the same vertices, ascending as these are; for several such groups
/// at once. `to_vert`: four vertices of each tet. Linear but for vertices that are the lowest of very many faces; 16
/// bytes per tet and 8 per point. Pre: vertices are below `point_count`; fewer than 2^30 tets. Errors: Cancelled.
template <class Visit>
void for_each_face_group(std::span<const std::uint32_t> to_vert, std::size_t point_count, const BlockLoop& loop,
                         const Visit& visit) {
  constexpr std::size_t kGrain = 1 << 10;
  const auto verts_of_face = [to_vert](FaceCode face) { return sorted(verts_of(to_vert.data(), face)).verts; };
  const Grouping by_lowest(point_count, [&](const auto& add) {
    loop.for_blocks(to_vert.size() / 4, kGrain, [&](std::size_t begin, std::size_t end) {
      for (const FaceCode face : FaceRange(begin, end)) {
        const TriangleVerts v = verts_of(to_vert.data(), face);
        add(static_cast<std::uint32_t>(face.index()), std::min({v[0], v[1], v[2]}));
      }
    });
  });
  loop.for_blocks(point_count, kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::pair<std::uint64_t, FaceCode>> keys;
    std::vector<FaceCode> group;
    for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
      keys.clear();
      for (const std::uint32_t index : by_lowest[v]) {
        const FaceCode face = FaceCode::at(index);
        const TriangleVerts verts = verts_of_face(face);
        keys.emplace_back(std::uint64_t{verts[1]} << 32 | verts[2], face);
      }
      std::sort(keys.begin(), keys.end());
      for (std::size_t i = 0; i < keys.size();) {
        group.clear();
        const std::uint64_t key = keys[i].first;
        for (; i < keys.size() && keys[i].first == key; ++i) group.push_back(keys[i].second);
        const TriangleVerts verts{v, static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)};
        visit(std::span<const FaceCode>(group), verts);
      }
    }
  });
}

}  // namespace tetloom::tets
