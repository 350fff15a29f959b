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

struct PackedVert {
  Vec3 point;
  VertKey key;
  std::uint64_t waits;
};

struct PackedTet {
  std::array<std::uint32_t, 4> verts;   // of those packed
  std::array<FaceCode, 4> to_neighbor;  // the same; not valid: not packed
  std::uint32_t region, fixed;
};

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

Bytes TetPacker::pack(std::span<const std::uint32_t> tets) {
  const TetMesh& mesh = state_.mesh;
  verts_.clear();
  verts_.set_item_count(mesh.points.size());
  for (const std::uint32_t tet : tets)
    for (std::size_t i = 0; i < 4; ++i) verts_.add(mesh.to_vert[std::size_t{tet} * 4 + i]);
  verts_.sort();
  MessageWriter writer;
  writer.put_each(verts_.items(), [&](std::uint32_t v) {
    return PackedVert{mesh.points[v], state_.keys[v], state_.waits[v]};
  });
  const TetPlaces places(tets);
  const std::span<PackedTet> packed_tets = writer.put_room<PackedTet>(tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    PackedTet& to = packed_tets[t];
    for (std::size_t i = 0; i < 4; ++i) {
      to.verts[i] = verts_[mesh.to_vert[std::size_t{tets[t]} * 4 + i]];
      const FaceCode behind = mesh.behind({tets[t], i});
      const std::uint32_t place = !behind.valid() ? kNone : places.find(behind.tet());
      to.to_neighbor[i] = place == kNone ? FaceCode() : behind.of_tet(place);
    }
    to.region = mesh.to_region[tets[t]], to.fixed = mesh.to_fixed[tets[t]];
  }
  return writer.take();
}

void take_out(PartState& state, std::span<const std::uint32_t> tets, std::vector<FaceCode>& opened) {
  TetMesh& mesh = state.mesh;
  for (const std::uint32_t tet : tets) {
    mesh.to_vert[std::size_t{tet} * 4] = kNone;
    state.qualities[tet] = tets::WorkingMesh::kDeadQuality;
  }
  state.has_dead |= !tets.empty();
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

Strip unpack_strip(std::span<const Bytes> pieces) {
  struct Piece {
    std::span<const PackedVert> verts;
    std::span<const PackedTet> tets;
  };
  std::vector<Piece> views;
  std::vector<PackedVert> verts;
  for (const Bytes& bytes : pieces) {
    MessageReader reader(bytes);
    Piece& piece = views.emplace_back();
    piece.verts = reader.get_view<PackedVert>();
    piece.tets = reader.get_view<PackedTet>();
    verts.insert(verts.end(), piece.verts.begin(), piece.verts.end());
  }
  const auto by_key = [](const PackedVert& a, const PackedVert& b) { return a.key < b.key; };
  std::stable_sort(verts.begin(), verts.end(), by_key);
  Strip strip;
  for (const PackedVert& vert : verts) {
    if (!strip.keys.empty() && strip.keys.back() == vert.key) {
      strip.waits[strip.keys.size() - 1] |= static_cast<std::uint8_t>(vert.waits);
      continue;
    }
    strip.surface_count += is_of_surface(vert.key);
    strip.keys.push_back(vert.key);
    strip.mesh.points.push_back(vert.point);
    strip.waits.push_back(static_cast<std::uint8_t>(vert.waits));
  }
  TetMesh& mesh = strip.mesh;
  for (const Piece& piece : views) {
    std::vector<std::uint32_t> to_vert;
    for (const PackedVert& vert : piece.verts)
      to_vert.push_back(static_cast<std::uint32_t>(std::lower_bound(strip.keys.begin(), strip.keys.end(), vert.key) -
                                                   strip.keys.begin()));
    const auto first = static_cast<std::uint32_t>(mesh.size());
    for (const PackedTet& tet : piece.tets) {
      for (const std::uint32_t v : tet.verts) mesh.to_vert.push_back(to_vert[v]);
      for (const FaceCode behind : tet.to_neighbor)
        mesh.to_neighbor.push_back(behind.valid() ? behind.of_tet(first + behind.tet()) : behind);
      mesh.to_region.push_back(tet.region);
      mesh.to_fixed.push_back(static_cast<std::uint8_t>(tet.fixed));
    }
  }
  link_strip(strip);
  return strip;
}

void link_strip(Strip& strip) {
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

void put_in(PartState& state, PartId part, Strip&& strip, std::vector<FaceCode>& open) {
  TetMesh& mesh = state.mesh;
  const std::uint32_t first_point = static_cast<std::uint32_t>(mesh.points.size());
  const auto first = static_cast<std::uint32_t>(mesh.size());
  // Vertices that the part has are those of its open faces.
  std::vector<std::uint32_t> to_vert(strip.mesh.points.size(), kNone);
  std::vector<char> seen(first_point, 0), is_in_strip(first_point, 0);
  const KeyFilter filter(strip.keys.span());
  for (const FaceCode face : open) {
    for (const std::uint32_t v : verts_of(mesh, face)) {
      if (std::exchange(seen[v], 1) || !filter.may_hold(state.keys[v])) continue;
      const auto at = std::lower_bound(strip.keys.begin(), strip.keys.end(), state.keys[v]);
      if (at == strip.keys.end() || *at != state.keys[v] || to_vert[at - strip.keys.begin()] != kNone) continue;
      to_vert[at - strip.keys.begin()] = v;
      is_in_strip[v] = 1;
    }
  }
  for (std::uint32_t v = 0; v < to_vert.size(); ++v) {
    const bool is_new = v >= strip.keys.size();
    const std::uint8_t waits = is_new ? std::uint8_t{0} : strip.waits[v];
    if (to_vert[v] != kNone) {
      state.waits[to_vert[v]] = waits;
      continue;
    }
    to_vert[v] = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.push_back(strip.mesh.points[v]);
    state.keys.push_back(is_new ? key_of(part, state.next_index++) : strip.keys[v]);
    state.waits.push_back(waits);
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
  state.qualities.append(strip.qualities.span());
  for (const FaceCode face : tets::FaceRange(first, mesh.size())) {
    if (mesh.behind(face).valid()) continue;
    sides.push_back({tets::sorted(verts_of(mesh, face)).verts, face});
    open.push_back(face);
  }
  link_pairs(mesh, sides);
  std::erase_if(open, [&](FaceCode face) { return mesh.behind(face).valid() || mesh.is_fixed(face); });
}

}  // namespace tetloom::parts
