#pragma once
// What a rank tells the others of what it has filled.
#include "mesher/volume/volume_parts.hpp"
#include "tetloom/communicator.hpp"

namespace tetloom::volume {

void put_figures(MessageWriter& writer, const FillingFigures& figures);
FillingFigures get_figures(MessageReader& reader);

/// Parts as of VolumeParts.
void put_part(MessageWriter& writer, const PartMesh& part);
PartMesh get_part(MessageReader& reader);

/// A part where it lies, in memory or in a message.
struct PartView {
  std::span<const Vec3> points;
  std::span<const std::uint64_t> vert_to_global;
  std::span<const std::uint32_t> tet_to_vert, tet_to_region, tri_to_vert, triangles;
};

PartView view_of(const PartMesh& part);
/// Of a message in which put_part was all; valid as long as the bytes are.
PartView get_view(MessageReader& reader);

}  // namespace tetloom::volume
