#pragma once
// Tets on their way between parts.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/parts/part_state.hpp"
#include "threading/parts/tet_packet.hpp"

namespace tetloom::parts {

/// Some of a part's tets as a message. `packer` is one of the part's mesh, for many pieces.
Bytes pack_piece(const PartTets& part, std::span<const std::uint32_t> tets, TetPacker<tets::TetMesh>& packer);

/// Takes the given tets out of the part's mesh; appends the faces that lie open for that.
void take_out(PartTets& part, std::span<const std::uint32_t> tets, std::vector<tets::FaceCode>& opened);

/// One strip of the pieces that parts have packed, in this order, linked where they meet. Pre: they do not overlap.
KeyedTets unpack_strip(std::vector<Bytes>&& pieces, const TaskRunner& runner);

/// Links the strip's tets through the faces that they share and are not linked through yet.
void link_strip(KeyedTets& strip);

/// Appends the strip, linked to those of `open`, the part's open faces, that it has too; its points that have no key
/// get one of `part`. Afterwards `open` holds the open faces as they have become.
void put_in(PartTets& tets, PartId part, KeyedTets&& strip, std::vector<tets::FaceCode>& open);

}  // namespace tetloom::parts
