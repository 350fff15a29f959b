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
/// bytes per tet and 8 per point where tets are few, otherwise a fourth of that, one range of vertices after the other. Pre: vertices are below `point_count`; fewer than 2^30 tets. Errors: Cancelled.
template <class Visit>
void for_each_face_group(std::span<const std::uint32_t> to_vert, std::size_t point_count, const BlockLoop& loop,
                         const Visit& visit) {
  constexpr std::size_t kGrain = 1 << 10;
  const auto verts_of_face = [to_vert](FaceCode face) { return sorted(verts_of(to_vert.data(), face)).verts; };
  const auto visit_range = [&](std::size_t first, std::size_t count) {
    const Grouping by_lowest(count, [&](const auto& add) {
      loop.for_blocks(to_vert.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end) {
        for (auto face = static_cast<FaceCode>(begin); face < end; ++face) {
          const TriangleVerts v = verts_of(to_vert.data(), face);
          const std::size_t lowest = std::min({v[0], v[1], v[2]}) - first;
          if (lowest < count) add(face, lowest);
        }
      });
    });
    loop.for_blocks(count, kGrain, [&](std::size_t begin, std::size_t end) {
      std::vector<std::pair<std::uint64_t, FaceCode>> keys;
      std::vector<FaceCode> group;
      for (std::size_t v = begin; v < end; ++v) {
        keys.clear();
        for (const FaceCode face : by_lowest[v]) {
          const TriangleVerts verts = verts_of_face(face);
          keys.emplace_back(std::uint64_t{verts[1]} << 32 | verts[2], face);
        }
        std::sort(keys.begin(), keys.end());
        for (std::size_t i = 0; i < keys.size();) {
          group.clear();
          const std::uint64_t key = keys[i].first;
          for (; i < keys.size() && keys[i].first == key; ++i) group.push_back(keys[i].second);
          const TriangleVerts verts{static_cast<std::uint32_t>(first + v), static_cast<std::uint32_t>(key >> 32),
                                    static_cast<std::uint32_t>(key)};
          visit(std::span<const FaceCode>(group), verts);
        }
      }
    });
  };
  constexpr std::size_t kFew = std::size_t{1} << 19, kRanges = 4;
  const std::size_t range = to_vert.size() < kFew ? point_count : point_count / kRanges + 1;
  for (std::size_t first = 0; first < point_count; first += range) visit_range(first, std::min(range, point_count - first));
}

}  // namespace tetloom::tets
