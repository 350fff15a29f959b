#include "core/mesh/mesh_access.hpp"

#include <string>

#include "core/base/error.hpp"

namespace tetloom {
namespace {

template <class Elements>
void require_indices(const Elements& elements, std::size_t entity_count, std::size_t point_count, const char* what) {
  if (elements.size() != entity_count)
    throw Error(ErrorCode::InvalidArgument, "the mesh has " + std::to_string(elements.size()) + " " + what + " but " +
                                                std::to_string(entity_count) + " entities for them");
  for (std::size_t i = 0; i < elements.size(); ++i)
    for (const std::uint32_t vertex : elements[i])
      if (vertex >= point_count)
        throw Error(Diagnostic{ErrorCode::InvalidArgument,
                               "element " + std::to_string(i) + " of the mesh's " + what + " refers to point " +
                                   std::to_string(vertex) + " of " + std::to_string(point_count),
                               {},
                               {},
                               {i}});
}

void require_lengths(const std::vector<MeshField>& fields, std::size_t carriers, const char* what) {
  for (const MeshField& field : fields) {
    const bool fits = field.components > 0 && field.values.size() % static_cast<std::size_t>(field.components) == 0 &&
                      field.values.size() / static_cast<std::size_t>(field.components) == carriers;
    if (!fits)
      throw Error(ErrorCode::InvalidArgument, "the field '" + field.name + "' has " +
                                                  std::to_string(field.values.size()) + " numbers in tuples of " +
                                                  std::to_string(field.components) + " for " +
                                                  std::to_string(carriers) + " " + what);
  }
}

}  // namespace

void require_consistent(const Mesh& mesh) {
  const std::size_t points = mesh.points.size();
  if (points >= 0xffffffffu) throw Error(ErrorCode::InvalidArgument, "the mesh has more than 2^32 - 2 points");
  if (!mesh.point_to_entity.empty() && mesh.point_to_entity.size() != points)
    throw Error(ErrorCode::InvalidArgument, "the mesh has " + std::to_string(points) + " points but " +
                                                std::to_string(mesh.point_to_entity.size()) + " entities for them");
  require_indices(mesh.edge_to_vert, mesh.edge_to_entity.size(), points, "edges");
  require_indices(mesh.tri_to_vert, mesh.tri_to_entity.size(), points, "triangles");
  require_indices(mesh.quad_to_vert, mesh.quad_to_entity.size(), points, "quadrilaterals");
  require_indices(mesh.tet_to_vert, mesh.tet_to_entity.size(), points, "tets");
  require_indices(mesh.pyramid_to_vert, mesh.pyramid_to_entity.size(), points, "pyramids");
  require_indices(mesh.prism_to_vert, mesh.prism_to_entity.size(), points, "prisms");
  require_indices(mesh.hex_to_vert, mesh.hex_to_entity.size(), points, "hexahedra");
  require_lengths(mesh.point_fields, points, "points");
  require_lengths(mesh.cell_fields, cell_count(mesh), "cells");
}

std::size_t cell_count(const Mesh& mesh, CellKind kind) {
  switch (kind) {
    case CellKind::Tet: return mesh.tet_to_vert.size();
    case CellKind::Pyramid: return mesh.pyramid_to_vert.size();
    case CellKind::Prism: return mesh.prism_to_vert.size();
    case CellKind::Hex: return mesh.hex_to_vert.size();
  }
  return 0;
}

std::size_t cell_count(const Mesh& mesh) {
  return mesh.tet_to_vert.size() + mesh.pyramid_to_vert.size() + mesh.prism_to_vert.size() + mesh.hex_to_vert.size();
}

CellRef cell_ref(const Mesh& mesh, std::size_t cell) {
  for (const CellKind kind : kAllCellKinds) {
    const std::size_t count = cell_count(mesh, kind);
    if (cell < count || kind == CellKind::Hex) return {kind, cell};
    cell -= count;
  }
  return {};
}

std::span<const std::uint32_t> vertices_of(const Mesh& mesh, CellRef cell) {
  switch (cell.kind) {
    case CellKind::Tet: return mesh.tet_to_vert[cell.index];
    case CellKind::Pyramid: return mesh.pyramid_to_vert[cell.index];
    case CellKind::Prism: return mesh.prism_to_vert[cell.index];
    case CellKind::Hex: return mesh.hex_to_vert[cell.index];
  }
  return {};
}

std::uint32_t region_of(const Mesh& mesh, CellRef cell) {
  switch (cell.kind) {
    case CellKind::Tet: return mesh.tet_to_entity[cell.index];
    case CellKind::Pyramid: return mesh.pyramid_to_entity[cell.index];
    case CellKind::Prism: return mesh.prism_to_entity[cell.index];
    case CellKind::Hex: return mesh.hex_to_entity[cell.index];
  }
  return ModelRegionId::kNone;
}

}  // namespace tetloom
