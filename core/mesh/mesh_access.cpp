#include "core/mesh/mesh_access.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "core/base/grain.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "tetloom/error.hpp"

namespace tetloom {
namespace {

constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

template <class Element>
bool fits(const Element& element, std::size_t point_count) {
  return std::all_of(element.begin(), element.end(), [&](std::uint32_t vertex) { return vertex < point_count; });
}

/// The first element that refers to a point which is not there; kNowhere without one.
template <class Element>
std::size_t find_misfit(const std::vector<Element>& elements, std::size_t point_count, const BlockLoop& loop) {
  const auto first = map_blocks(loop, elements.size(), kCopyGrain, kNowhere,
                                [&](std::size_t begin, std::size_t end, std::size_t& misfit) {
                                  while (begin < end && fits(elements[begin], point_count)) ++begin;
                                  if (begin < end) misfit = begin;
                                });
  return first.empty() ? kNowhere : *std::min_element(first.begin(), first.end());
}

template <class Element>
void require_indices(const std::vector<Element>& elements, std::size_t entity_count, std::size_t point_count,
                     const char* what, const BlockLoop& loop) {
  if (elements.size() != entity_count)
    throw Error(ErrorCode::InvalidArgument, "the mesh has " + std::to_string(elements.size()) + " " + what + " but " +
                                                std::to_string(entity_count) + " entities for them");
  const std::size_t misfit = find_misfit(elements, point_count, loop);
  if (misfit == kNowhere) return;
  const auto vertex =
      std::find_if(elements[misfit].begin(), elements[misfit].end(), [&](std::uint32_t v) { return v >= point_count; });
  throw Error(Diagnostic{ErrorCode::InvalidArgument,
                         "element " + std::to_string(misfit) + " of the mesh's " + what + " refers to point " +
                             std::to_string(*vertex) + " of " + std::to_string(point_count),
                         {},
                         {},
                         {misfit}});
}

/// The first of `count` entities that is not below `limit`; kNowhere without one.
template <class IndexOf>
std::size_t find_entity_from(std::uint32_t limit, std::size_t count, const BlockLoop& loop, const IndexOf& index_of) {
  const auto is_beyond = [&](std::size_t i) { return index_of(i) != kNone && index_of(i) >= limit; };
  const auto first =
      map_blocks(loop, count, kCopyGrain, kNowhere, [&](std::size_t begin, std::size_t end, std::size_t& found) {
        while (begin < end && !is_beyond(begin)) ++begin;
        if (begin < end) found = begin;
      });
  return first.empty() ? kNowhere : *std::min_element(first.begin(), first.end());
}

template <class IndexOf>
void require_below(std::uint32_t limit, std::size_t count, const char* what, const BlockLoop& loop,
                   const IndexOf& index_of) {
  const std::size_t found = find_entity_from(limit, count, loop, index_of);
  if (found == kNowhere) return;
  const std::uint64_t tag = std::uint64_t{index_of(found)} + 1;
  throw Error(Diagnostic{ErrorCode::InputUnsuitable,
                         "element " + std::to_string(found) + " of the mesh's " + what +
                             " lies on the entity with tag " + std::to_string(tag) + "; tags up to " +
                             std::to_string(limit) + " are supported",
                         {},
                         {},
                         {found}});
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

void require_consistent(const Mesh& mesh, const BlockLoop& loop) {
  const std::size_t points = mesh.points.size();
  if (points >= 0xffffffffu) throw Error(ErrorCode::InvalidArgument, "the mesh has more than 2^32 - 2 points");
  if (!mesh.point_to_entity.empty() && mesh.point_to_entity.size() != points)
    throw Error(ErrorCode::InvalidArgument, "the mesh has " + std::to_string(points) + " points but " +
                                                std::to_string(mesh.point_to_entity.size()) + " entities for them");
  require_indices(mesh.edge_to_vert, mesh.edge_to_entity.size(), points, "edges", loop);
  require_indices(mesh.tri_to_vert, mesh.tri_to_entity.size(), points, "triangles", loop);
  require_indices(mesh.quad_to_vert, mesh.quad_to_entity.size(), points, "quadrilaterals", loop);
  require_indices(mesh.tet_to_vert, mesh.tet_to_entity.size(), points, "tets", loop);
  require_indices(mesh.pyramid_to_vert, mesh.pyramid_to_entity.size(), points, "pyramids", loop);
  require_indices(mesh.prism_to_vert, mesh.prism_to_entity.size(), points, "prisms", loop);
  require_indices(mesh.hex_to_vert, mesh.hex_to_entity.size(), points, "hexahedra", loop);
  if (const auto fault = find_mid_node_fault(mesh, loop))
    throw Error(ErrorCode::InvalidArgument, "the mesh: " + *fault);
  require_lengths(mesh.point_fields, points, "points");
  require_lengths(mesh.cell_fields, cell_count(mesh), "cells");
}

void require_entities_below(const Mesh& mesh, std::uint32_t limit, const BlockLoop& loop) {
  const auto require = [&](const std::vector<std::uint32_t>& entities, const char* what) {
    require_below(limit, entities.size(), what, loop, [&](std::size_t i) { return entities[i]; });
  };
  require_below(limit, mesh.point_to_entity.size(), "points", loop,
                [&](std::size_t i) { return mesh.point_to_entity[i].index; });
  require(mesh.edge_to_entity, "edges");
  require(mesh.tri_to_entity, "triangles");
  require(mesh.quad_to_entity, "quadrilaterals");
  require(mesh.tet_to_entity, "tets");
  require(mesh.pyramid_to_entity, "pyramids");
  require(mesh.prism_to_entity, "prisms");
  require(mesh.hex_to_entity, "hexahedra");
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
