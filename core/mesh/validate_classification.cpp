#include <algorithm>
#include <numeric>

#include "core/mesh/incidence_detail.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "core/mesh/validate_detail.hpp"

namespace tetloom::detail {
namespace {

/// Whether a point classified on `point` can lie on the closure of entity `index` of dimension `dim`: on the entity
/// itself or on something of lower dimension. Unknown classifications may lie anywhere.
bool may_lie_on(const ModelEntity& point, int dim, std::uint32_t index) {
  if (!point.valid() || point.dim < dim) return true;
  return point.dim == dim && (index == kNone || point.index == index);
}

template <class Element>
bool lies_on_closure(const Mesh& mesh, const Element& element, int dim, std::uint32_t index) {
  return std::all_of(element.begin(), element.end(),
                     [&](std::uint32_t v) { return may_lie_on(entity_of_point(mesh, v), dim, index); });
}

// Points inside of a model edge, as far as they are classified so, that have a piece of this edge.
std::vector<std::uint8_t> points_on_own_edge(const Mesh& mesh) {
  std::vector<std::uint8_t> found(mesh.points.size(), 0);
  for (std::size_t e = 0; e < mesh.edge_to_vert.size(); ++e)
    for (const std::uint32_t v : mesh.edge_to_vert[e])
      if (entity_of_point(mesh, v) == ModelEntity(1, mesh.edge_to_entity[e])) found[v] = 1;
  return found;
}

// Model edges may have been merged: a piece of one may end inside of another one that has a piece there too.
bool is_edge_on_closure(const Mesh& mesh, std::size_t e, const std::vector<std::uint8_t>& on_own_edge) {
  return std::ranges::all_of(mesh.edge_to_vert[e], [&](std::uint32_t v) {
    return may_lie_on(entity_of_point(mesh, v), 1, mesh.edge_to_entity[e]) ||
           (entity_of_point(mesh, v).dim == 1 && on_own_edge[v] != 0);
  });
}

std::size_t count_classified(const std::vector<std::uint32_t>& entities, const BlockLoop& loop) {
  const auto counts = map_blocks(loop, entities.size(), std::size_t{1} << 15, std::size_t{0},
                                 [&](std::size_t begin, std::size_t end, std::size_t& classified) {
                                   for (std::size_t e = begin; e < end; ++e) classified += entities[e] != kNone;
                                 });
  return std::accumulate(counts.begin(), counts.end(), std::size_t{0});
}

void check_entities(const Mesh& mesh, const std::vector<std::uint32_t>& entities, int dim, ElementKind kind,
                    const BlockLoop& loop, ProblemLog& log) {
  std::size_t known = mesh.entities[dim].empty() ? kNone : mesh.entities[dim].size();
  if (dim == 2 && !mesh.face_to_sides.empty()) known = std::min(known, mesh.face_to_sides.size());
  const bool some_are_classified = count_classified(entities, loop) > 0;
  log_blocks(mesh, entities.size(), loop, log, [&](std::size_t begin, std::size_t end, ProblemLog& of_block) {
    for (std::size_t e = begin; e < end; ++e) {
      if (entities[e] != kNone && entities[e] >= known) of_block.add(ProblemKind::EntityOutOfRange, kind, e);
      if (entities[e] == kNone && some_are_classified) of_block.add(ProblemKind::PartlyClassified, kind, e);
    }
  });
}

void check_point(const Mesh& mesh, const PointMarks& marks, std::size_t i, ProblemLog& log) {
  const ModelEntity entity = entity_of_point(mesh, i);
  if (!entity.valid()) return;
  if (!mesh.entities[entity.dim].empty() && entity.index >= mesh.entities[entity.dim].size())
    log.add(ProblemKind::EntityOutOfRange, ElementKind::Point, i);
  if (!marks.used[i]) return;
  const bool off_face = entity.dim == 2 && surface_count(mesh) > 0 && !marks.on_surface[i];
  const bool off_edge = entity.dim == 1 && !mesh.edge_to_vert.empty() && !marks.on_edge[i];
  if (off_face || off_edge) log.add(ProblemKind::ClassificationConflict, ElementKind::Point, i);
}

}  // namespace

void validate_classification(const Mesh& mesh, const PointMarks& marks, const BlockLoop& loop, ProblemLog& log) {
  log_blocks(mesh, vertex_count(mesh), loop, log, [&](std::size_t begin, std::size_t end, ProblemLog& of_block) {
    for (std::size_t i = begin; i < end; ++i) check_point(mesh, marks, i, of_block);
  });
  const auto check = [&](const auto& elements, const auto& entities, int dim, ElementKind kind) {
    check_entities(mesh, entities, dim, kind, loop, log);
    log_blocks(mesh, elements.size(), loop, log, [&](std::size_t begin, std::size_t end, ProblemLog& of_block) {
      for (std::size_t e = begin; e < end; ++e)
        if (!lies_on_closure(mesh, elements[e], dim, entities[e]))
          of_block.add(ProblemKind::ClassificationConflict, kind, e);
    });
  };
  check_entities(mesh, mesh.edge_to_entity, 1, ElementKind::Edge, loop, log);
  const std::vector<std::uint8_t> on_own_edge = points_on_own_edge(mesh);
  log_blocks(mesh, mesh.edge_to_vert.size(), loop, log, [&](std::size_t begin, std::size_t end, ProblemLog& of_block) {
    for (std::size_t e = begin; e < end; ++e)
      if (!is_edge_on_closure(mesh, e, on_own_edge))
        of_block.add(ProblemKind::ClassificationConflict, ElementKind::Edge, e);
  });
  check(mesh.tri_to_vert, mesh.tri_to_entity, 2, ElementKind::Triangle);
  check(mesh.quad_to_vert, mesh.quad_to_entity, 2, ElementKind::Quad);
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto& entities) {
    check(cells, entities, 3, element_kind(kind));
  });
}

}  // namespace tetloom::detail
