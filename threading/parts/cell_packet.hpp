#pragma once
// The form in which cells travel from one part to another: the cells of each kind by the places of their vertices in
// the message, and these vertices, each once and under the key by which all parts know it. What else is known of cells
// and vertices stands beside, as arrays in the same order.
#include <cstddef>
#include <cstdint>
#include <span>

#include "tetloom/storage.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// Cells of one kind, where they lie in a message.
struct PacketCells {
  explicit PacketCells(MessageReader& reader)
      : to_place(reader.get_view<std::uint32_t>()), to_region(reader.get_view<std::uint32_t>()) {}
  PacketCells() = default;

  std::size_t size() const { return to_region.size(); }
  std::size_t vertex_count() const { return size() == 0 ? 0 : to_place.size() / size(); }  ///< of each cell
  /// Writes the vertices of the cells [begin, end), which the receiver numbers as `to_local` says, where `out` has
  /// those of the first of all.
  void put_verts(std::span<const std::uint32_t> to_local, std::size_t begin, std::size_t end,
                 std::uint32_t* out) const {
    const std::size_t n = vertex_count();
    for (std::size_t i = begin * n; i < end * n; ++i) out[i] = to_local[to_place[i]];
  }

  std::span<const std::uint32_t> to_place, to_region;
};

/// Puts cells of `n` vertices each, whose numbers in `block` are higher by `first`. `block` has the arrays `to_vert`
/// and `to_region`; `place(vert)` is where the message has a vertex.
template <class Block, class Place>
void put_packet_cells(MessageWriter& writer, const Block& block, std::size_t n, std::span<const std::uint32_t> cells,
                      std::uint32_t first, const Place& place) {
  std::uint32_t* out = writer.put_room<std::uint32_t>(cells.size() * n).data();
  for (const std::uint32_t cell : cells) {
    const std::uint32_t* verts = block.to_vert.data() + std::size_t{cell - first} * n;
    for (std::size_t i = 0; i < n; ++i) *out++ = place(verts[i]);
  }
  writer.put_each(cells, [&](std::uint32_t cell) { return block.to_region[cell - first]; });
}

/// Vertices, where they lie in a message.
struct PacketVerts {
  explicit PacketVerts(MessageReader& reader)
      : keys(reader.get_view<std::uint64_t>()), points(reader.get_view<Vec3>()) {}
  PacketVerts() = default;

  std::size_t size() const { return points.size(); }

  std::span<const std::uint64_t> keys;
  std::span<const Vec3> points;
};

/// Puts vertices; `key(vert)` has 64 bits.
template <class Points, class Key>
void put_packet_verts(MessageWriter& writer, std::span<const std::uint32_t> verts, const Points& points,
                      const Key& key) {
  writer.put_each(verts, [&](std::uint32_t v) { return std::uint64_t{key(v)}; });
  writer.put_each(verts, [&](std::uint32_t v) { return points[v]; });
}

}  // namespace tetloom
