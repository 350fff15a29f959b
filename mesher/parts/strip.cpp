#include "mesher/parts/strip.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "core/tets/triangle_verts.hpp"
#include "core/tets/working_mesh.hpp"
#include "mesher/parts/key_filter.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;
using tets::TriangleVerts;

// A face by its vertices; equal ones are the two sides of the same.
struct Side {
  TriangleVerts verts;
  FaceCode face;
  friend bool operator<(const Side& a, const Side& b) { return a.verts < b.verts; }
};

// Places of tets in a list, by an open table.
class TetPlaces {
 public:
  explicit TetPlaces(std::span<const std::uint32_t> tets)
      : tets_(tets),
        shift_(32 - static_cast<int>(std::bit_width(tets.size() * 2 | 1))),
        to_place_(std::size_t{1} << (32 - shift_), kNone) {
    for (std::uint32_t i = 0; i < tets.size(); ++i) to_place_[slot_of(tets[i])] = i;
  }
  /// kNone where the tet is not in the list.
  std::uint32_t find(std::uint32_t tet) const { return to_place_[slot_of(tet)]; }

 private:
  // Where the tet stands, or is to.
  std::size_t slot_of(std::uint32_t tet) const {
    std::size_t slot = tet * 0x9e3779b9u >> shift_;
    while (to_place_[slot] != kNone && tets_[to_place_[slot]] != tet) slot = (slot + 1) % to_place_.size();
    return slot;
  }

  std::span<const std::uint32_t> tets_;
  int shift_;
  std::vector<std::uint32_t> to_place_;
};

// Links sides in pairs, those of `mesh`; the others stay as they are.
void link_pairs(TetMesh& mesh, std::span<Side> sides) {
  std::sort(sides.begin(), sides.end());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    if (sides[i].verts != sides[i + 1].verts) continue;
    mesh.behind(sides[i].face) = sides[i + 1].face;
    mesh.behind(sides[i + 1].face) = sides[i].face;
    ++i;
  }
}

}  // namespace

Bytes pack_piece(const PartTets& part, std::span<const std::uint32_t> tets, TetPacker<TetMesh>& packer) {
  packer.begin(tets);
  const TetPlaces places(tets);
  const auto link = [&](FaceCode face) {
    const FaceCode behind = part.mesh.behind(face);
    const std::uint32_t place = !behind.valid() ? kNone : places.find(behind.tet());
    return place == kNone ? FaceCode() : behind.of_tet(place);
  };
  MessageWriter writer;
  packer.put(writer, [&](std::uint32_t v) { return part.keys[v]; });
  packer.put_links(writer, link);
  writer.put_each(packer.verts(), [&](std::uint32_t v) { return part.waits[v]; });
  writer.put_each(tets, [&](std::uint32_t tet) { return part.mesh.to_fixed[tet]; });
  return writer.take();
}

void take_out(PartTets& part, std::span<const std::uint32_t> tets, std::vector<FaceCode>& opened) {
  TetMesh& mesh = part.mesh;
  for (const std::uint32_t tet : tets) {
    mesh.to_vert[std::size_t{tet} * 4] = kNone;
    part.qualities[tet] = tets::WorkingMesh::kDeadQuality;
  }
  part.has_dead |= !tets.empty();
  for (const std::uint32_t tet : tets) {
    for (const FaceCode face : FaceCode::of(tet)) {
      const FaceCode behind = mesh.behind(face);
      if (!behind.valid() || mesh.is_dead(behind.tet())) continue;
      mesh.behind(behind) = {};
      opened.push_back(behind);
    }
    mesh.to_fixed[tet] = 0;
  }
}

KeyedTets unpack_strip(std::vector<Bytes>&& pieces, const TaskRunner& runner) {
  TetPackets packets(std::move(pieces));
  KeyedTets strip;
  std::vector<std::span<const std::uint8_t>> waits;
  for (TetPacket& packet : packets.all()) {
    packet.take_links();
    waits.push_back(packet.rest.get_view<std::uint8_t>());
    strip.mesh.to_fixed.append(packet.rest.get_view<std::uint8_t>());
  }
  packets.number_verts(runner, [&](VertKey key, std::uint32_t packet, std::uint32_t place, bool is_new) {
    if (!is_new) {
      strip.waits[strip.keys.size() - 1] |= waits[packet][place];
      return;
    }
    strip.surface_count += is_of_surface(key);
    strip.keys.push_back(key);
    strip.mesh.points.push_back(packets.all()[packet].verts.points[place]);
    strip.waits.push_back(waits[packet][place]);
  });
  packets.move_linked_tets_into(strip.mesh, runner, [](const TetPacket& packet, FaceCode link) {
    return link.of_tet(packet.first_tet + link.tet());
  });
  link_strip(strip);
  return strip;
}

void link_strip(KeyedTets& strip) {
  TetMesh& mesh = strip.mesh;
  mesh.to_neighbor.resize(mesh.to_vert.size());
  // By lowest vertex first: there are few at each.
  std::vector<Side> alone;
  for (const FaceCode face : mesh.faces())
    if (!mesh.behind(face).valid()) alone.push_back({tets::sorted(verts_of(mesh, face)).verts, face});
  std::vector<std::uint32_t> end(mesh.points.size() + 1, 0);
  for (const Side& side : alone) ++end[side.verts[0] + 1];
  for (std::size_t v = 1; v < end.size(); ++v) end[v] += end[v - 1];
  std::vector<Side> sides(alone.size());
  for (const Side& side : alone) sides[end[side.verts[0]]++] = side;
  std::uint32_t begin = 0;
  for (std::size_t v = 0; v < mesh.points.size(); begin = end[v++])
    if (end[v] - begin > 1) link_pairs(mesh, std::span(sides).subspan(begin, end[v] - begin));
}

void put_in(PartTets& tets, PartId part, KeyedTets&& strip, std::vector<FaceCode>& open) {
  TetMesh& mesh = tets.mesh;
  const std::uint32_t first_point = static_cast<std::uint32_t>(mesh.points.size());
  const auto first = static_cast<std::uint32_t>(mesh.size());
  // Vertices that the part has are those of its open faces.
  std::vector<std::uint32_t> to_vert(strip.mesh.points.size(), kNone);
  std::vector<char> seen(first_point, 0), is_in_strip(first_point, 0);
  const KeyFilter filter(strip.keys.span());
  for (const FaceCode face : open) {
    for (const std::uint32_t v : verts_of(mesh, face)) {
      if (std::exchange(seen[v], 1) || !filter.may_hold(tets.keys[v])) continue;
      const auto at = std::lower_bound(strip.keys.begin(), strip.keys.end(), tets.keys[v]);
      if (at == strip.keys.end() || *at != tets.keys[v] || to_vert[at - strip.keys.begin()] != kNone) continue;
      to_vert[at - strip.keys.begin()] = v;
      is_in_strip[v] = 1;
    }
  }
  for (std::uint32_t v = 0; v < to_vert.size(); ++v) {
    const bool is_new = v >= strip.keys.size();
    const std::uint8_t waits = is_new ? std::uint8_t{0} : strip.waits[v];
    if (to_vert[v] != kNone) {
      tets.waits[to_vert[v]] = waits;
      continue;
    }
    to_vert[v] = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.push_back(strip.mesh.points[v]);
    tets.keys.push_back(is_new ? key_of(part, tets.next_index++) : strip.keys[v]);
    tets.waits.push_back(waits);
  }
  std::vector<Side> sides;
  for (const FaceCode face : open) {
    const TriangleVerts verts = verts_of(mesh, face);
    if (is_in_strip[verts[0]] && is_in_strip[verts[1]] && is_in_strip[verts[2]])
      sides.push_back({tets::sorted(verts).verts, face});
  }
  for (const std::uint32_t v : strip.mesh.to_vert) mesh.to_vert.push_back(to_vert[v]);
  for (const FaceCode face : strip.mesh.to_neighbor)
    mesh.to_neighbor.push_back(face.valid() ? face.of_tet(first + face.tet()) : face);
  mesh.to_region.append(strip.mesh.to_region.span());
  mesh.to_fixed.append(strip.mesh.to_fixed.span());
  tets.qualities.append(strip.qualities.span());
  for (const FaceCode face : tets::FaceRange(first, mesh.size())) {
    if (mesh.behind(face).valid()) continue;
    sides.push_back({tets::sorted(verts_of(mesh, face)).verts, face});
    open.push_back(face);
  }
  link_pairs(mesh, sides);
  std::erase_if(open, [&](FaceCode face) { return mesh.behind(face).valid() || mesh.is_fixed(face); });
}

}  // namespace tetloom::parts
