// A part as bytes, to be adapted by another rank.
#include "adapt/kernel/cavity_mesh.hpp"

namespace tetloom::adapt {

namespace {

struct EdgePiece {
  std::array<std::uint32_t, 2> verts;
  std::uint32_t edge;
};

// Calls visit(array) for all arrays of a part, in the same order.
template <class Part, class Visit>
void for_each_array(Part& part, const Visit& visit) {
  visit(part.mesh.points), visit(part.mesh.to_vert), visit(part.mesh.to_neighbor), visit(part.mesh.to_region);
  visit(part.mesh.to_fixed), visit(part.to_quality), visit(part.to_metric), visit(part.to_entity);
  visit(part.vert_to_tet), visit(part.to_hint), visit(part.to_frozen), visit(part.to_state);
}

}  // namespace

void CavityMesh::put(MessageWriter& writer) const {
  for_each_array(*this, [&]<class T>(const GrowingArray<T>& array) { writer.put_array<T>(array.span()); });
  std::vector<SurfaceTriangle> triangles;
  surface.for_each_triangle([&](const SurfaceTriangle& triangle) { triangles.push_back(triangle); });
  writer.put_array<SurfaceTriangle>(triangles);
  std::vector<EdgePiece> pieces;
  surface.for_each_edge([&](std::uint32_t a, std::uint32_t b, std::uint32_t edge) {
    pieces.push_back({{a, b}, edge});
  });
  writer.put_array<EdgePiece>(pieces);
  writer.put(surely_positive_);
  writer.put(editor_.first_dead());
}

CavityMesh CavityMesh::get(MessageReader& reader) {
  CavityMesh part;
  for_each_array(part, [&]<class T>(GrowingArray<T>& array) { array.append(reader.get_view<T>()); });
  for (const SurfaceTriangle& triangle : reader.get_view<SurfaceTriangle>()) part.surface.add(triangle);
  for (const EdgePiece& piece : reader.get_view<EdgePiece>())
    part.surface.add_edge(piece.verts[0], piece.verts[1], piece.edge);
  part.surely_positive_ = reader.get<double>();
  part.editor_.set_first_dead(reader.get<FaceCode>());
  return part;
}

}  // namespace tetloom::adapt
