#include "core/tets/face_groups.hpp"

namespace tetloom::tets {

FaceGroups::FaceGroups(std::span<const std::uint32_t> to_vert, std::size_t point_count, const BlockLoop& loop)
    : to_vert_(to_vert) {
  by_lowest_ = Grouping(point_count, to_vert.size(), [&](const auto& visit) {
    loop.for_blocks(to_vert.size(), 4 * kGrain, [&](std::size_t begin, std::size_t end) {
      for (auto face = static_cast<FaceCode>(begin); face < end; ++face) {
        const TriangleVerts v = verts_of(face);
        visit(face, std::min({v[0], v[1], v[2]}));
      }
    });
  });
}

FaceCode FaceGroups::find(const TriangleVerts& verts) const {
  FaceCode lowest = kNone;
  for (const FaceCode face : by_lowest_[verts[0]])
    if (sorted(verts_of(face)).verts == verts) lowest = std::min(lowest, face);
  return lowest;
}

}  // namespace tetloom::tets
