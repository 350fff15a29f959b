#include "tetloom/part_mesh.hpp"

namespace tetloom {
namespace {

template <class T>
std::size_t bytes_of(const GrowingArray<T>& array) {
  return array.capacity() * sizeof(T);
}

}  // namespace

std::size_t memory_of(const PartMesh& part) {
  std::size_t bytes = bytes_of(part.points) + bytes_of(part.vert_to_entity) + bytes_of(part.vert_to_global) +
                      bytes_of(part.vert_to_place) + bytes_of(part.further_places);
  for (const CellBlock& block : part.cells)
    bytes += bytes_of(block.to_vert) + bytes_of(block.to_neighbor) + bytes_of(block.to_region);
  for (const BoundaryBlock& block : part.boundary) bytes += bytes_of(block.to_vert) + bytes_of(block.to_entity);
  for (const VertexField& field : part.vertex_fields) bytes += bytes_of(field.values);
  for (const CellField& field : part.cell_fields)
    for (const auto& values : field.values) bytes += bytes_of(values);
  return bytes;
}

}  // namespace tetloom
