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

/// The faces of tets by their lowest vertices. Looks at the vertices that it was made of, which have to stay. 16 bytes
/// per tet and 8 per point.
class FaceGroups {
 public:
  /// `to_vert`: four vertices of each tet. Pre: they are below `point_count`; fewer than 2^30 tets. Errors: Cancelled.
  FaceGroups(std::span<const std::uint32_t> to_vert, std::size_t point_count, const BlockLoop& loop);

  /// Calls visit(faces) for all faces that have the same vertices, ascending; for several such groups at once. Linear
  /// but for vertices that are the lowest of very many faces.
  template <class Visit>
  void for_each(const BlockLoop& loop, const Visit& visit) const {
    loop.for_blocks(by_lowest_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      std::vector<std::pair<std::uint64_t, FaceCode>> keys;
      std::vector<FaceCode> group;
      for (std::size_t v = begin; v < end; ++v) {
        keys.clear();
        for (const FaceCode face : by_lowest_[v]) {
          const TriangleVerts verts = sorted(verts_of(face)).verts;
          keys.emplace_back(std::uint64_t{verts[1]} << 32 | verts[2], face);
        }
        std::sort(keys.begin(), keys.end());
        for (std::size_t i = 0; i < keys.size();) {
          group.clear();
          const std::uint64_t key = keys[i].first;
          for (; i < keys.size() && keys[i].first == key; ++i) group.push_back(keys[i].second);
          visit(std::span<const FaceCode>(group));
        }
      }
    });
  }

  /// The lowest face with these vertices, which ascend; kNone where there is none.
  FaceCode find(const TriangleVerts& verts) const;

  /// The vertices of a face, counter-clockwise seen from outside a tet of positive volume.
  TriangleVerts verts_of(FaceCode face) const {
    const std::uint32_t* v = &to_vert_[std::size_t{face / 4} * 4];
    const auto& f = kFaceVerts[face % 4];
    return {v[f[0]], v[f[1]], v[f[2]]};
  }

 private:
  static constexpr std::size_t kGrain = 1 << 10;

  std::span<const std::uint32_t> to_vert_;
  Grouping by_lowest_;  // faces by their lowest vertices
};

}  // namespace tetloom::tets
