#pragma once
// Faces on their way from the rank that made them to the others.
#include <optional>

#include "mesher/surface/face_cut.hpp"
#include "mesher/surface/face_mesher.hpp"
#include "tetloom/communicator.hpp"

namespace tetloom {

void put_face_mesh(MessageWriter& writer, const FaceMesh& face);
FaceMesh get_face_mesh(MessageReader& reader);

void put_face_cut(MessageWriter& writer, const std::optional<FaceCut>& cut);
std::optional<FaceCut> get_face_cut(MessageReader& reader);

}  // namespace tetloom
