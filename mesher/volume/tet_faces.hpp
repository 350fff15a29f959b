#pragma once
// Which tetrahedra lie on the two sides of each triangle.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetloom::volume {

using TetVertices = std::array<std::uint32_t, 4>;

/// The corners of face i of a tetrahedron, the one opposite to corner i, counter-clockwise seen from outside when the
/// volume is positive.
//         3
//        /|\       face 0: 1 2 3    face 1: 0 3 2
//       / | \      face 2: 0 1 3    face 3: 0 2 1
//      0--|--2
//       \ | /
//         1
inline constexpr std::array<std::array<int, 3>, 4> kFaceToCorner{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// A face of one tetrahedron: 4 * tet + i.
inline constexpr std::uint32_t kNoFace = 0xffffffffu;

struct TetFaces {
  std::vector<std::uint32_t> face_to_mate;  ///< per face of a tet, the same face of its neighbour; kNoFace at the hull
  bool conforming = true;                   ///< false when more than two tets have one face
};

/// Pairs the faces of a mesh. Pre: fewer than 2^30 tets, indices below point_count. O(n) in the number of tets.
TetFaces pair_faces(std::span<const TetVertices> tet_to_vert, std::size_t point_count);

/// Finds faces of tets by their vertices.
class FaceLookup {
 public:
  FaceLookup(std::span<const TetVertices> tet_to_vert, std::size_t point_count);
  /// The up to two faces with these corners; kNoFace where there is none. Pre: at most two tets have one face.
  std::array<std::uint32_t, 2> find(std::array<std::uint32_t, 3> corners) const;
  std::span<const std::uint32_t> faces_at(std::uint32_t lowest_vertex) const {
    return std::span(faces_).subspan(first_[lowest_vertex], first_[lowest_vertex + 1] - first_[lowest_vertex]);
  }
  std::array<std::uint32_t, 3> corners_of(std::uint32_t face) const;  ///< ascending

 private:
  std::span<const TetVertices> tet_to_vert_;
  std::vector<std::uint32_t> first_, faces_;  // faces by their lowest vertex
};

/// 1 when `corners` runs around the face as kFaceToCorner does, -1 when the other way.
int turn_of(const TetVertices& tet, int face, const std::array<std::uint32_t, 3>& corners);

}  // namespace tetloom::volume
