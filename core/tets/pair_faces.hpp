#pragma once
// Links tetrahedra through the faces that two of them share, of tetrahedra of which only the vertices are known; in
// their order, on one thread, without memory beside the links.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace tetloom::tets {

/// Faces that have not met their other side yet, in chains: each chain's first face stands at its head, further ones in
/// the links of those before them. Pairs `face` with the face of the chain that is_same(other) accepts, or else puts it
/// there. `link_of(face)` is what stands behind a face.
template <class Face, class LinkOf, class IsSame>
void pair_or_chain(Face& head, Face face, const LinkOf& link_of, const IsSame& is_same) {
  Face* link = &head;
  for (Face other = head; other.valid(); other = *link) {
    Face& next = link_of(other);
    if (is_same(other)) {
      *link = next;
      next = face;
      link_of(face) = other;
      return;
    }
    link = &next;
  }
  link_of(face) = head;
  head = face;
}

/// Empties the chains: faces that are left in them have nothing behind them.
template <class Face, class LinkOf>
void empty_chains(std::span<Face> heads, const LinkOf& link_of) {
  for (Face& head : heads)
    while (head.valid()) head = std::exchange(link_of(head), Face());
}

/// Pairs all faces of the tets, `to_vert` with four vertices each. `face_of(index)` names a face by its place in arrays
/// of four per tet and `index_of(face)` is the inverse; `heads` of the chains, one per vertex, are empty before, and to
/// be emptied afterwards. Where three tets share a face, two of them are linked.
template <class Face, class FaceOf, class IndexOf, class LinkOf>
void pair_faces(std::span<const std::uint32_t> to_vert, std::span<Face> heads, const FaceOf& face_of,
                const IndexOf& index_of, const LinkOf& link_of) {
  // Without building keys: among faces of the same lowest vertex, the sum of the vertices and the highest one decide.
  const auto sum_of = [](const std::uint32_t* v) { return std::uint64_t{v[0]} + v[1] + v[2] + v[3]; };
  for (std::size_t tet = 0; tet < to_vert.size() / 4; ++tet) {
    const std::uint32_t* v = to_vert.data() + tet * 4;
    const auto [low01, high01] = std::minmax(v[0], v[1]);
    const auto [low23, high23] = std::minmax(v[2], v[3]);
    const std::uint32_t low = std::min(low01, low23), high = std::max(high01, high23);
    const auto [second, third] = std::minmax(std::max(low01, low23), std::min(high01, high23));
    for (std::size_t side = 0; side < 4; ++side) {
      const std::uint64_t sum = sum_of(v) - v[side];
      const std::uint32_t highest = v[side] == high ? third : high;
      const auto is_same = [&](Face other) {
        const std::size_t at = index_of(other), left_out = at % 4;
        const std::uint32_t* w = to_vert.data() + (at - left_out);
        if (sum_of(w) - w[left_out] != sum) return false;
        std::uint32_t other_highest = 0;
        for (std::size_t i = 0; i < 4; ++i)
          other_highest = i == left_out ? other_highest : std::max(other_highest, w[i]);
        return other_highest == highest;
      };
      pair_or_chain(heads[v[side] == low ? second : low], face_of(tet * 4 + side), link_of, is_same);
    }
  }
}

}  // namespace tetloom::tets
