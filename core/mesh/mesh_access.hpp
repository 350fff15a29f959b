#pragma once
// Small questions to a Mesh that everything which handles meshes asks.
#include <cstddef>
#include <cstdint>
#include <span>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom {

/// Throws Error(InvalidArgument) when an array has the wrong length, an index is out of range, or the length of a field
/// does not fit, or mid nodes are not as `Mesh` says. `point_to_entity` may be empty, which stands for "all unknown".
/// Linear.
void require_consistent(const Mesh& mesh, const BlockLoop& loop = serial_loop());

/// Throws Error(InputUnsuitable), with the first element and its tag, unless the indices of all entities that points
/// and elements lie on are below `limit`; "no entity" is fine. Pre: require_consistent. Linear.
void require_entities_below(const Mesh& mesh, std::uint32_t limit, const BlockLoop& loop = serial_loop());

/// The entity of point `i`, invalid where unknown. Pre: i < mesh.points.size().
inline ModelEntity entity_of_point(const Mesh& mesh, std::size_t i) {
  return mesh.point_to_entity.empty() ? ModelEntity{} : mesh.point_to_entity[i];
}

/// Calls visit(kind, x_to_vert, x_to_entity) for the four kinds of cells, in the order of CellKind. `AnyMesh` is Mesh
/// or const Mesh.
template <class AnyMesh, class Visit>
void for_each_cell_kind(AnyMesh& mesh, const Visit& visit) {
  visit(CellKind::Tet, mesh.tet_to_vert, mesh.tet_to_entity);
  visit(CellKind::Pyramid, mesh.pyramid_to_vert, mesh.pyramid_to_entity);
  visit(CellKind::Prism, mesh.prism_to_vert, mesh.prism_to_entity);
  visit(CellKind::Hex, mesh.hex_to_vert, mesh.hex_to_entity);
}

/// Calls visit(x_to_vert, x_to_entity) for triangles and for quadrilaterals.
template <class AnyMesh, class Visit>
void for_each_surface_kind(AnyMesh& mesh, const Visit& visit) {
  visit(mesh.tri_to_vert, mesh.tri_to_entity);
  visit(mesh.quad_to_vert, mesh.quad_to_entity);
}

/// How many cells of one kind, and of all kinds, there are.
std::size_t cell_count(const Mesh& mesh, CellKind kind);
std::size_t cell_count(const Mesh& mesh);

/// How many triangles and quadrilaterals there are.
inline std::size_t surface_count(const Mesh& mesh) { return mesh.tri_to_vert.size() + mesh.quad_to_vert.size(); }

/// A cell by its kind and its place among those of the kind.
struct CellRef {
  CellKind kind = CellKind::Tet;
  std::size_t index = 0;
};

/// The vertices and the region of a cell. Pre: it is there.
std::span<const std::uint32_t> vertices_of(const Mesh& mesh, CellRef cell);
std::uint32_t region_of(const Mesh& mesh, CellRef cell);

}  // namespace tetloom
