#pragma once
// Which bodies of a document are valid, each asked once however often it is placed. Private to core/cad.
#include <TopoDS_Face.hxx>
#include <TopTools_MapOfShape.hxx>
#include <vector>

#include "core/cad/detail/document.hpp"

namespace tetloom::cad {

/// What BRepCheck says of a face with its wires, edges and vertices. Only reads.
bool is_valid_face(const TopoDS_Face& face);

/// What BRepCheck says of the shells of a body, given that its faces are valid.
bool has_valid_shells(const TopoDS_Shape& body);

/// Solids, shells outside solids and faces outside shells, each once and without its location.
std::vector<TopoDS_Shape> distinct_bodies(const TopoDS_Shape& root);

/// Does this face keep helpers inside, which two threads must not use at once?
bool has_offset_surface(const TopoDS_Face& face);

/// Calls body(i) for every face: side by side, but for faces on offset surfaces.
template <class Body>
void for_each_face(const std::vector<TopoDS_Face>& faces, const BlockLoop& loop, const Body& body) {
  std::vector<std::size_t> safe, others;
  for (std::size_t i = 0; i < faces.size(); ++i) (has_offset_surface(faces[i]) ? others : safe).push_back(i);
  loop.for_blocks(safe.size(), 1, [&](std::size_t k, std::size_t) { body(safe[k]); });
  for (const std::size_t i : others) body(i);
}

/// Checks the bodies that are not known to be valid yet, and notes those that are. Returns the others.
std::vector<TopoDS_Shape> find_invalid_bodies(Document& document, const CancelToken* cancel, const BlockLoop& loop);

/// The bodies in their places, each once, that are not known to be valid.
std::vector<TopoDS_Shape> suspect_bodies(const Document& document);

}  // namespace tetloom::cad
