#include "core/tets/vertex_star.hpp"

namespace tetloom::tets {

namespace {

// The tets of a star: open addressing, at most half full. Marks in the mesh would cost a cache line per tet.
class TetSet {
 public:
  TetSet() { slots_.fill(kNone); }

  // Whether it was not there yet. Branches on that cannot be predicted, so there are none but for a full slot.
  bool add(std::uint32_t tet) {
    std::uint32_t slot = tet * 0x9e3779b1u >> 24;
    while (slots_[slot] != tet && slots_[slot] != kNone) [[unlikely]] slot = (slot + 1) % kSlots;
    const bool is_new = slots_[slot] == kNone;
    slots_[slot] = tet;
    return is_new;
  }

 private:
  static constexpr std::uint32_t kSlots = 256;
  static_assert(kSlots >= 2 * WorkingMesh::kMostTets);
  std::array<std::uint32_t, kSlots> slots_;
};

}  // namespace

StarVerdict find_star(const WorkingMesh& mesh, std::uint32_t tet, std::uint32_t corner, VertexStar& star) {
  const TetMesh& m = mesh.mesh();
  star.vertex = mesh.verts(tet)[corner];
  star.count = 0;
  if (mesh.is_fixed_point(star.vertex)) return StarVerdict::OnSurface;
  TetSet seen;
  seen.add(tet);
  // Entered, as it were, through one of the faces at the vertex; what is behind that one is found from elsewhere.
  star.codes[0] = {tet, (corner + 1) % 4};
  std::size_t count = 1;
  for (std::size_t i = 0; i < count; ++i) {
    if (count > WorkingMesh::kMostTets) return StarVerdict::TooLarge;
    const std::uint32_t here = star.codes[i].tet(), entry = star.codes[i].side();
    const std::uint32_t own = mesh.corner_of(here, star.vertex);
    star.codes[i] = {here, own};
    for (const std::uint8_t face : kOtherCorners[own][entry]) {
      const FaceCode behind = m.behind({here, face});
      star.codes[count] = behind;
      count += seen.add(behind.tet());
      mesh.prefetch(behind.tet());
    }
    mesh.prefetch_point(m.to_vert[std::size_t{here} * 4 + entry]);
  }
  star.count = count;
  return StarVerdict::Found;
}

}  // namespace tetloom::tets
