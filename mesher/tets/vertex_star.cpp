#include "mesher/tets/vertex_star.hpp"

namespace tetloom::tets {

namespace {

// The tets of a star, for the question whether one is in it: open addressing, at most half full.
class TetSet {
 public:
  TetSet() { slots_.fill(kNone); }

  // False when it was there already.
  bool add(std::uint32_t tet) {
    std::uint32_t slot = tet * 0x9e3779b1u >> 24;
    while (slots_[slot] != tet) {
      if (slots_[slot] == kNone) {
        slots_[slot] = tet;
        return true;
      }
      slot = (slot + 1) % kSlots;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kSlots = 256;
  static_assert(kSlots >= 2 * WorkingMesh::kMostTets);
  std::array<std::uint32_t, kSlots> slots_;
};

}  // namespace

StarVerdict find_star(const WorkingMesh& mesh, std::uint32_t tet, std::uint32_t corner, VertexStar& star) {
  const TetMesh& m = mesh.mesh();
  star.vertex = m.to_vert[std::size_t{tet} * 4 + corner];
  star.count = 0;
  if (mesh.is_fixed_point(star.vertex)) return StarVerdict::OnSurface;
  TetSet seen;
  seen.add(tet);
  std::size_t count = 1;
  star.codes[0] = tet;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t here = star.codes[i], own = mesh.corner_of(here, star.vertex);
    star.codes[i] = here * 4 + own;
    for (std::uint32_t k = 1; k < 4; ++k) {
      const std::uint32_t face = (own + k) % 4, behind = m.to_neighbor[std::size_t{here} * 4 + face] / 4;
      mesh.prefetch_point(m.to_vert[std::size_t{here} * 4 + face]);
      if (!seen.add(behind)) continue;
      if (count == WorkingMesh::kMostTets) return StarVerdict::TooLarge;
      mesh.prefetch(behind);
      star.codes[count++] = behind;
    }
  }
  star.count = count;
  return StarVerdict::Found;
}

}  // namespace tetloom::tets
