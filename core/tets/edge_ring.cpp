#include "core/tets/edge_ring.hpp"

#include <algorithm>
#include <utility>

namespace tetloom::tets {

namespace {

// Of a triangle's sides, the corners opposite to them in the tets at b and at a: see tets_over.
constexpr std::array<std::uint32_t, 2> kOppositeFirst{0, 0}, kOppositeMiddle{1, 2}, kOppositeLast{2, 1};

}  // namespace

RingFilling::RingFilling(const TetMesh& mesh, const EdgeRing& ring)
    : ring_(ring), region_(mesh.to_region[ring.tets[0]]) {
  for (std::size_t i = 0; i < ring.old().size(); ++i) {
    const std::uint32_t tet = ring.tets[i];
    const FaceCode at_b = tet * 4 + corner_of(mesh, tet, ring.a), at_a = tet * 4 + corner_of(mesh, tet, ring.b);
    sides_[i] = {{{mesh.to_neighbor[at_b], mesh.is_fixed(at_b)}, {mesh.to_neighbor[at_a], mesh.is_fixed(at_a)}}};
  }
}

void RingFilling::fill(TetMesh& mesh, std::span<const RingTriangle> triangles,
                       std::span<const std::uint32_t> ids) const {
  const auto last_of_ring = static_cast<std::size_t>(ring_.count) - 1;
  for (const std::uint32_t tet : ids) mesh.to_region[tet] = region_, mesh.to_fixed[tet] = 0;
  const auto link = [&](FaceCode face, const Side& side) {
    mesh.to_neighbor[face] = side.behind;
    if (side.behind != kNone) mesh.to_neighbor[side.behind] = face;
    if (side.is_fixed) mesh.to_fixed[face / 4] |= static_cast<std::uint8_t>(1u << face % 4);
  };
  if (ring_.count == 2) {
    // Two tets between the same vertices, of which one is inverted: what lies around them closes over them.
    for (std::size_t end = 0; end < 2; ++end) {
      const auto& [one, other] = std::pair(sides_[0][end], sides_[1][end]);
      if (one.behind != kNone) link(one.behind, {other.behind, other.is_fixed});
      if (other.behind != kNone) link(other.behind, {one.behind, one.is_fixed});
    }
    return;
  }
  FaceCode open[kMostRingVerts][kMostRingVerts][2];  // faces over diagonals whose second triangle comes later
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [first, middle, last] = triangles[t];
    const auto verts = tets_over(ring_, triangles[t]);
    for (std::size_t end = 0; end < 2; ++end) {
      const std::uint32_t tet = ids[2 * t + end];
      std::copy(verts[end].begin(), verts[end].end(), &mesh.to_vert[std::size_t{tet} * 4]);
      mesh.to_neighbor[tet * 4 + 3] = ids[2 * t + 1 - end] * 4 + 3;
      const auto pass_on = [&](std::size_t i, std::size_t j, FaceCode face) {
        if (j == i + 1) {
          link(face, sides_[i][end]);
        } else {
          open[i][j][end] = face;
        }
      };
      pass_on(first, middle, tet * 4 + kOppositeLast[end]);
      pass_on(middle, last, tet * 4 + kOppositeFirst[end]);
      link(tet * 4 + kOppositeMiddle[end],
           first == 0 && last == last_of_ring ? sides_[last][end] : Side{open[first][last][end], false});
    }
  }
}

}  // namespace tetloom::tets
