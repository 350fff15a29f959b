#include "core/tets/cavity_filling.hpp"

#include <algorithm>
#include <tuple>

namespace tetloom::tets {

// Without a branch: the order of a face's vertices cannot be predicted.
inline CavityFilling::Key CavityFilling::key_of(const TriangleVerts& v) {
  const std::uint32_t low = std::min(v[0], std::min(v[1], v[2])), high = std::max(v[0], std::max(v[1], v[2]));
  return {std::uint64_t{low} << 32 | (v[0] ^ v[1] ^ v[2] ^ low ^ high), high};
}

// Of the faces with these vertices the first that `accept` takes; where it takes none, a place for one more, which is
// Wanted if one of them is, or else Gone.
template <class Accept>
inline CavityFilling::Slot& CavityFilling::find(const Key& key, const Accept& accept) {
  Slot* spare = nullptr;
  std::size_t at = (key.lower ^ std::uint64_t{key.highest} << 16) * 0x9e3779b97f4a7c15u >> shift_;
  for (;; at = at + 1 == slots_.size() ? 0 : at + 1) {
    Slot& slot = slots_[at];
    if (slot.stamp != stamp_) {
      if (spare) return *spare;
      slot = {key, {}, {}, stamp_, State::Gone, false};
      return slot;
    }
    if (!(slot.key == key)) continue;
    if (accept(slot)) return slot;
    if (slot.state == State::Wanted || (slot.state == State::Gone && !spare)) spare = &slot;
  }
}

void CavityFilling::open(const TetMesh& mesh, std::span<const std::uint32_t> old, std::size_t made_count) {
  // More than there are faces, so that a search ends.
  const std::size_t room = std::bit_ceil((old.size() + made_count + 1) * 4 + 1);
  if (room > slots_.size()) slots_.assign(room, Slot{}), stamp_ = 0;
  shift_ = 64 - std::countr_zero(room);
  if (++stamp_ == 0) {
    for (Slot& slot : slots_) slot.stamp = 0;
    stamp_ = 1;
  }
  unmet_ = 0;
  after_.clear();
  for (const std::uint32_t tet : old)
    for (const FaceCode face : FaceCode::of(tet)) add_old(mesh, face);
}

void CavityFilling::add_old(const TetMesh& mesh, FaceCode face) {
  const FaceCode behind = mesh.behind(face);
  Slot& slot = find(key_of(verts_of(mesh, face)),
                    [behind](const Slot& other) { return other.state == State::Outer && other.own == behind; });
  if (slot.state == State::Outer) {  // between two of the cavity's tets
    slot.state = slot.is_fixed ? State::Wanted : State::Gone;
    --unmet_;
  } else {
    slot.state = State::Outer, slot.code = behind, slot.own = face, slot.is_fixed = mesh.is_fixed(face);
    ++unmet_;
  }
}

void CavityFilling::swap_surface(std::span<const TriangleVerts> before, std::span<const TriangleVerts> after) {
  for (const TriangleVerts& triangle : before) {
    Slot& slot = find(key_of(triangle), is_unmet);
    if (slot.state == State::Outer && !slot.code.valid()) slot.state = State::Gone, --unmet_;
  }
  for (const TriangleVerts& triangle : after) {
    Slot& slot = find(after_.emplace_back(key_of(triangle)), is_unmet);
    if (slot.state == State::Gone) slot.state = State::Wanted;
    slot.is_fixed = true;
  }
}

// A face, or nothing, where the slot's has been waiting for one.
void CavityFilling::meet(TetMesh& mesh, Slot& slot, FaceCode face, bool is_fixed) {
  link_sides(mesh, face, slot.code, is_fixed || slot.is_fixed);
  slot.state = State::Gone;
  --unmet_;
}

void CavityFilling::add_made(TetMesh& mesh, FaceCode face) {
  Slot& slot = find(key_of(verts_of(mesh, face)), is_unmet);
  if (is_unmet(slot)) return meet(mesh, slot, face, false);
  slot.is_fixed = slot.state == State::Wanted;
  slot.state = State::Made, slot.code = face;
  ++unmet_;
}

// Faces of the boundary between which nothing lies any more.
void CavityFilling::meet_rest(TetMesh& mesh) {
  std::vector<Slot*> rest;
  for (Slot& slot : slots_)
    if (slot.stamp == stamp_ && is_unmet(slot)) rest.push_back(&slot);
  std::ranges::sort(rest, [](const Slot* a, const Slot* b) {
    return std::tie(a->key.lower, a->key.highest, a->code) < std::tie(b->key.lower, b->key.highest, b->code);
  });
  for (std::size_t i = 0; i + 1 < rest.size(); ++i) {
    Slot &one = *rest[i], &other = *rest[i + 1];
    if (!(one.key == other.key)) continue;
    meet(mesh, one, other.code, other.is_fixed);
    other.state = State::Gone;
    --unmet_, ++i;
  }
}

bool CavityFilling::close(TetMesh& mesh, std::span<const std::uint32_t> made) {
  for (const std::uint32_t tet : made)
    for (const FaceCode face : FaceCode::of(tet)) add_made(mesh, face);
  for (const Key& key : after_)
    if (Slot& slot = find(key, is_unmet); is_unmet(slot)) meet(mesh, slot, {}, true);
  if (unmet_ > 0) meet_rest(mesh);
  return unmet_ == 0;
}

}  // namespace tetloom::tets
