#include "mesher/volume/tet_faces.hpp"

#include <algorithm>

namespace tetloom::volume {

FaceLookup::FaceLookup(std::span<const TetVertices> tet_to_vert, std::size_t point_count)
    : tet_to_vert_(tet_to_vert), first_(point_count + 2, 0), faces_(tet_to_vert.size() * 4) {
  for (std::uint32_t face = 0; face < faces_.size(); ++face) ++first_[corners_of(face)[0] + 2];
  for (std::size_t v = 2; v < first_.size(); ++v) first_[v] += first_[v - 1];
  for (std::uint32_t face = 0; face < faces_.size(); ++face) faces_[first_[corners_of(face)[0] + 1]++] = face;
}

std::array<std::uint32_t, 3> FaceLookup::corners_of(std::uint32_t face) const {
  const TetVertices& tet = tet_to_vert_[face / 4];
  const auto& [i, j, k] = kFaceToCorner[face % 4];
  std::array corners{tet[i], tet[j], tet[k]};
  std::sort(corners.begin(), corners.end());
  return corners;
}

std::array<std::uint32_t, 2> FaceLookup::find(std::array<std::uint32_t, 3> corners) const {
  std::sort(corners.begin(), corners.end());
  std::array<std::uint32_t, 2> found{kNoFace, kNoFace};
  for (const std::uint32_t face : faces_at(corners[0])) {
    if (corners_of(face) == corners) found[found[0] == kNoFace ? 0 : 1] = face;
  }
  return found;
}

TetFaces pair_faces(std::span<const TetVertices> tet_to_vert, std::size_t point_count) {
  const FaceLookup lookup(tet_to_vert, point_count);
  TetFaces result;
  result.face_to_mate.assign(tet_to_vert.size() * 4, kNoFace);
  struct Entry {
    std::array<std::uint32_t, 3> corners;
    std::uint32_t face;
    auto operator<=>(const Entry&) const = default;
  };
  std::vector<Entry> ring;
  for (std::uint32_t v = 0; v < point_count; ++v) {
    ring.clear();
    for (const std::uint32_t face : lookup.faces_at(v)) ring.push_back({lookup.corners_of(face), face});
    std::sort(ring.begin(), ring.end());
    for (std::size_t i = 0; i + 1 < ring.size(); ++i) {
      if (ring[i].corners != ring[i + 1].corners) continue;
      if (i + 2 < ring.size() && ring[i + 2].corners == ring[i].corners) result.conforming = false;
      result.face_to_mate[ring[i].face] = ring[i + 1].face;
      result.face_to_mate[ring[i + 1].face] = ring[i].face;
    }
  }
  return result;
}

int turn_of(const TetVertices& tet, int face, const std::array<std::uint32_t, 3>& corners) {
  const auto& [i, j, k] = kFaceToCorner[face];
  const std::array own{tet[i], tet[j], tet[k]};
  const auto start = std::find(own.begin(), own.end(), corners[0]) - own.begin();
  return own[(start + 1) % 3] == corners[1] ? 1 : -1;
}

}  // namespace tetloom::volume
