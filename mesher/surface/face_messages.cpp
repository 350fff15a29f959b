#include "mesher/surface/face_messages.hpp"

#include "core/base/codec.hpp"

namespace tetloom {
namespace {

template <class T>
void put_list(MessageWriter& writer, const std::vector<T>& values) {
  writer.put_array(std::span<const T>(values));
}

template <class T>
void get_list(MessageReader& reader, std::vector<T>& values) {
  values = reader.get_array<T>();
}

}  // namespace

void put_face_mesh(MessageWriter& writer, const FaceMesh& face) {
  writer.put(face.verdict);
  put_text(writer, face.message);
  put_list(writer, face.points);
  put_list(writer, face.tri_to_vert);
  put_list(writer, face.crossing_edges);
  writer.put(face.point);
  writer.put(static_cast<std::uint64_t>(face.inverted));
}

FaceMesh get_face_mesh(MessageReader& reader) {
  FaceMesh face;
  face.verdict = reader.get<FaceVerdict>();
  face.message = get_text(reader);
  get_list(reader, face.points);
  get_list(reader, face.tri_to_vert);
  get_list(reader, face.crossing_edges);
  face.point = reader.get<Vec3>();
  face.inverted = reader.get<std::uint64_t>();
  return face;
}

void put_face_cut(MessageWriter& writer, const std::optional<FaceCut>& cut) {
  writer.put(cut.has_value());
  if (!cut) return;
  writer.put(cut->scale);
  writer.put(cut->has_poles);
  put_list(writer, cut->vertices);
  put_list(writer, cut->kinds);
  writer.put(static_cast<std::uint64_t>(cut->pieces.size()));
  for (const FacePiece& piece : cut->pieces) {
    put_list(writer, piece.vertices);
    put_list(writer, piece.segments);
  }
  put_list(writer, cut->zones);
  writer.put(static_cast<std::uint64_t>(cut->junctions.size()));
  for (const std::vector<std::uint32_t>& pieces : cut->junctions) put_list(writer, pieces);
  put_list(writer, cut->junction_to_vertex);
}

std::optional<FaceCut> get_face_cut(MessageReader& reader) {
  if (!reader.get<bool>()) return {};
  FaceCut cut;
  cut.scale = reader.get<Vec2>();
  cut.has_poles = reader.get<bool>();
  get_list(reader, cut.vertices);
  get_list(reader, cut.kinds);
  cut.pieces.resize(reader.get<std::uint64_t>());
  for (FacePiece& piece : cut.pieces) {
    get_list(reader, piece.vertices);
    get_list(reader, piece.segments);
  }
  get_list(reader, cut.zones);
  cut.junctions.resize(reader.get<std::uint64_t>());
  for (std::vector<std::uint32_t>& pieces : cut.junctions) get_list(reader, pieces);
  get_list(reader, cut.junction_to_vertex);
  return cut;
}

}  // namespace tetloom
