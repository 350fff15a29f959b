#include "mesher/tets/face_groups.hpp"

#include <atomic>

namespace tetloom::tets {

FaceGroups::FaceGroups(std::span<const std::uint32_t> to_vert, std::size_t point_count, const BlockLoop& loop)
    : to_vert_(to_vert) {
  const auto for_each_face = [&](const auto& visit) {
    loop.for_blocks(to_vert.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t face = begin; face < end; ++face) {
        const TriangleVerts v = verts_of(static_cast<FaceCode>(face));
        visit(static_cast<FaceCode>(face), std::min({v[0], v[1], v[2]}));
      }
    });
  };
  // Counted, then placed from the ends to the begins. Partner of each access: the same for faces of other tets at the
  // vertex. Their order in faces_ depends on who comes first; nothing that is told of them does.
  begins_.resize(point_count + 1, 0);
  for_each_face([&](FaceCode, std::uint32_t lowest) {
    std::atomic_ref(begins_[lowest]).fetch_add(1, std::memory_order_relaxed);
  });
  for (std::size_t v = 0; v < point_count; ++v) begins_[v + 1] += begins_[v];
  faces_.resize_for_overwrite(to_vert.size());
  for_each_face([&](FaceCode face, std::uint32_t lowest) {
    faces_[std::atomic_ref(begins_[lowest]).fetch_sub(1, std::memory_order_relaxed) - 1] = face;
  });
}

FaceCode FaceGroups::find(const TriangleVerts& verts) const {
  FaceCode lowest = kNone;
  for (std::size_t i = begins_[verts[0]]; i < begins_[verts[0] + 1]; ++i)
    if (sorted(verts_of(faces_[i])).verts == verts) lowest = std::min(lowest, faces_[i]);
  return lowest;
}

}  // namespace tetloom::tets
