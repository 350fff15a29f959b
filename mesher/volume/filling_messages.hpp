#pragma once
// What a rank tells the others of what it has filled.
#include "mesher/volume/volume_parts.hpp"
#include "tetloom/communicator.hpp"

namespace tetloom::volume {

void put_figures(MessageWriter& writer, const FillingFigures& figures);
FillingFigures get_figures(MessageReader& reader);

void put_part(MessageWriter& writer, const VolumePart& part);
VolumePart get_part(MessageReader& reader);

/// A part where it lies, in memory or in a message.
struct VolumePartView {
  std::span<const Vec3> points;
  std::span<const std::uint64_t> vert_to_number;
  std::span<const std::uint32_t> tet_to_vert, tet_to_region, triangles;
  std::span<const std::array<std::uint32_t, 3>> tri_to_vert;
};

VolumePartView view_of(const VolumePart& part);
/// Of a message in which put_part was all; valid as long as the bytes are.
VolumePartView get_view(const Bytes& bytes);

}  // namespace tetloom::volume
