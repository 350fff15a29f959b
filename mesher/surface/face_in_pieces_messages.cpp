// Pieces, zones and junctions on their way from the rank that made them to the others.
#include "mesher/surface/face_in_pieces.hpp"

namespace tetloom {

void FaceInPieces::put_part(std::size_t number, MessageWriter& writer) const {
  const Part& part = parts_[number];
  writer.put(part.failed);
  writer.put_array(std::span<const PatchVertex>(part.own));
  writer.put_array(std::span<const FaceTriangle>(part.kept));
  writer.put_array(std::span<const LooseTriangle>(part.loose));
  writer.put_array(std::span<const std::uint32_t>(part.dropped));
  writer.put_array(std::span<const std::uint32_t>(part.moved));
  for (const std::uint32_t id : part.moved) writer.put(vertex(id));
}

void FaceInPieces::take_part(std::size_t number, MessageReader& reader) {
  Part& part = parts_[number];
  part.failed = reader.get<bool>();
  part.own = reader.get_array<PatchVertex>();
  part.kept = reader.get_array<FaceTriangle>();
  part.loose = reader.get_array<LooseTriangle>();
  part.dropped = reader.get_array<std::uint32_t>();
  part.moved = reader.get_array<std::uint32_t>();
  for (const std::uint32_t id : part.moved) vertex(id) = reader.get<PatchVertex>();
}

}  // namespace tetloom
