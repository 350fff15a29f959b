#pragma once
// Tets on their way from one part to another, where parts have nothing else, and, where they are linked through their
// faces, these links.
//
// Any mesh of tets will do that has the arrays `points`, `to_vert` and `to_region` of tets::TetMesh, and `to_neighbor`
// for links. What else is known of vertices and tets follows in the message, as arrays in the same order.
#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/local_numbers.hpp"
#include "core/tets/tet_mesh.hpp"
#include "tetloom/tasks.hpp"
#include "threading/parts/cell_packet.hpp"
#include "threading/runtime/parallel_sort.hpp"

namespace tetloom {

/// Makes packets of one mesh, one after the other.
template <class TetArrays>
class TetPacker {
 public:
  explicit TetPacker(const TetArrays& mesh) : mesh_(mesh) {}

  /// The next packet is of these tets.
  void begin(std::span<const std::uint32_t> tets) {
    tets_ = tets;
    verts_.clear();
    verts_.set_item_count(mesh_.points.size());
    for (const std::uint32_t tet : tets)
      for (std::size_t i = 0; i < 4; ++i) verts_.add(mesh_.to_vert[std::size_t{tet} * 4 + i]);
  }
  /// Of the mesh, in the order of the packet.
  std::span<const std::uint32_t> tets() const { return tets_; }
  std::span<const std::uint32_t> verts() const { return verts_.items(); }
  /// Where the packet has a vertex.
  std::uint32_t place_of(std::uint32_t vert) const { return verts_[vert]; }

  /// Puts the packet. `key(vert)` has 64 bits.
  template <class Key>
  void put(MessageWriter& writer, const Key& key) const {
    put_packet_cells(writer, mesh_, 4, tets_, 0, [&](std::uint32_t v) { return verts_[v]; });
    put_packet_verts(writer, verts(), mesh_.points, key);
  }
  /// After the packet. `link(face)` says what is behind a face: the same face by the place of its tet in the packet, or
  /// by a name that the receiver knows.
  template <class Link>
  void put_links(MessageWriter& writer, const Link& link) const {
    writer.put_each(tets_, [&](std::uint32_t tet) { return tets::of_faces(tet, link); });
  }

 private:
  const TetArrays& mesh_;
  std::span<const std::uint32_t> tets_;
  LocalNumbers verts_;
};

/// What one message holds, where it lies.
struct TetPacket {
  explicit TetPacket(const Bytes& bytes) : rest(bytes), tets(rest), verts(rest) {}
  /// Where links follow.
  void take_links() { to_neighbor = rest.get_view<std::array<tets::FaceCode, 4>>(); }

  MessageReader rest;  ///< what follows in the message
  PacketCells tets;
  PacketVerts verts;
  std::span<const std::array<tets::FaceCode, 4>> to_neighbor;
  std::uint32_t first_tet = 0;          ///< place of its first tet among those of all packets
  std::vector<std::uint32_t> to_local;  ///< of its vertices, once they are numbered
};

/// Packets of several parts, in this order, to become one mesh.
class TetPackets {
 public:
  explicit TetPackets(std::vector<Bytes>&& messages) : messages_(std::move(messages)) {
    for (const Bytes& bytes : messages_) {
      TetPacket& packet = packets_.emplace_back(bytes);
      packet.first_tet = static_cast<std::uint32_t>(tet_count_);
      tet_count_ += packet.tets.size();
    }
  }
  std::span<TetPacket> all() { return packets_; }
  std::span<const TetPacket> all() const { return packets_; }
  std::size_t tet_count() const { return tet_count_; }

  /// Numbers the vertices of all packets in ascending order of their keys, those with one key alike. Calls
  /// take(key, packet, place, is_new) for each, in this order.
  template <class Take>
  void number_verts(const TaskRunner& runner, const Take& take) {
    std::vector<KeyedVert> verts = keyed_verts();
    parallel_sort(verts, runner);
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < verts.size(); ++i) {
      const auto& [key, packet, place] = verts[i];
      const bool is_new = i == 0 || verts[i - 1].key != key;
      count += is_new;
      packets_[packet].to_local[place] = count - 1;
      take(key, packet, place, is_new);
    }
  }

  /// Makes a mesh of all tets, and frees the messages.
  template <class TetArrays>
  void move_tets_into(TetArrays& mesh, const TaskRunner& runner) {
    move_tets(mesh, runner, [](const TetPacket&, std::size_t) {});
  }
  /// The same with the links, which all packets have: `find(packet, link)` says what is behind a face of the packet at
  /// hand that has something there.
  template <class TetArrays, class Find>
  void move_linked_tets_into(TetArrays& mesh, const TaskRunner& runner, const Find& find) {
    mesh.to_neighbor.resize_for_overwrite(tet_count_ * 4);
    move_tets(mesh, runner, [&](const TetPacket& packet, std::size_t tet) {
      for (std::size_t i = 0; i < 4; ++i) {
        const tets::FaceCode link = packet.to_neighbor[tet][i];
        mesh.to_neighbor[(packet.first_tet + tet) * 4 + i] = link.valid() ? find(packet, link) : link;
      }
    });
  }

 private:
  template <class TetArrays, class More>
  void move_tets(TetArrays& mesh, const TaskRunner& runner, const More& more) {
    constexpr std::size_t kGrain = std::size_t{1} << 14;
    mesh.to_vert.resize_for_overwrite(tet_count_ * 4), mesh.to_region.reserve(tet_count_);
    for (std::size_t p = 0; p < packets_.size(); ++p) {
      const TetPacket& packet = packets_[p];
      mesh.to_region.append(packet.tets.to_region);
      runner.for_blocks(packet.tets.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        packet.tets.put_verts(packet.to_local, begin, end, mesh.to_vert.data() + std::size_t{packet.first_tet} * 4);
        for (std::size_t tet = begin; tet < end; ++tet) more(packet, tet);
      });
      packets_[p].to_local = {}, messages_[p] = Bytes();
    }
  }

  struct KeyedVert {
    std::uint64_t key;
    std::uint32_t packet, place;
    auto operator<=>(const KeyedVert&) const = default;
  };

  std::vector<KeyedVert> keyed_verts() {
    std::vector<KeyedVert> verts;
    for (std::uint32_t p = 0; p < packets_.size(); ++p) {
      const std::span<const std::uint64_t> keys = packets_[p].verts.keys;
      packets_[p].to_local.resize(keys.size());
      for (std::uint32_t i = 0; i < keys.size(); ++i) verts.push_back({keys[i], p, i});
    }
    return verts;
  }

  std::vector<Bytes> messages_;
  std::vector<TetPacket> packets_;
  std::size_t tet_count_ = 0;
};

}  // namespace tetloom
