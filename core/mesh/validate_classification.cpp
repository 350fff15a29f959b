#include "core/mesh/incidence_detail.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/validate_detail.hpp"

namespace tetloom::detail {
namespace {

/// Whether a point classified on `point` can lie on the closure of entity `index` of dimension `dim`: on the entity
/// itself or on something of lower dimension. Unknown classifications may lie anywhere.
bool may_lie_on(const ModelEntity& point, int dim, std::uint32_t index) {
  if (!point.valid() || point.dim < dim) return true;
  return point.dim == dim && (index == kNone || point.index == index);
}

template <class Elements>
void check_closure(const Mesh& mesh, const Elements& elements, const std::vector<std::uint32_t>& entities, int dim,
                   ElementKind kind, ProblemLog& log) {
  for (std::size_t e = 0; e < elements.size(); ++e)
    for (const std::uint32_t v : elements[e])
      if (!may_lie_on(entity_of_point(mesh, v), dim, entities[e])) {
        log.add(ProblemKind::ClassificationConflict, kind, e);
        break;
      }
}

void check_entities(const Mesh& mesh, const std::vector<std::uint32_t>& entities, int dim, ElementKind kind,
                    ProblemLog& log) {
  std::size_t known = mesh.entities[dim].empty() ? kNone : mesh.entities[dim].size();
  if (dim == 2 && !mesh.face_to_sides.empty()) known = std::min(known, mesh.face_to_sides.size());
  std::size_t classified = 0;
  for (const std::uint32_t entity : entities) classified += entity != kNone;
  for (std::size_t e = 0; e < entities.size(); ++e) {
    if (entities[e] != kNone && entities[e] >= known) log.add(ProblemKind::EntityOutOfRange, kind, e);
    if (entities[e] == kNone && classified > 0) log.add(ProblemKind::PartlyClassified, kind, e);
  }
}

void check_points(const Mesh& mesh, const PointMarks& marks, ProblemLog& log) {
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const ModelEntity entity = entity_of_point(mesh, i);
    if (!entity.valid()) continue;
    if (!mesh.entities[entity.dim].empty() && entity.index >= mesh.entities[entity.dim].size())
      log.add(ProblemKind::EntityOutOfRange, ElementKind::Point, i);
    if (!marks.used[i]) continue;
    const bool off_face = entity.dim == 2 && surface_count(mesh) > 0 && !marks.on_surface[i];
    const bool off_edge = entity.dim == 1 && !mesh.edge_to_vert.empty() && !marks.on_edge[i];
    if (off_face || off_edge) log.add(ProblemKind::ClassificationConflict, ElementKind::Point, i);
  }
}

}  // namespace

void validate_classification(const Mesh& mesh, const PointMarks& marks, ProblemLog& log) {
  check_points(mesh, marks, log);
  const auto check = [&](const auto& elements, const auto& entities, int dim, ElementKind kind) {
    check_entities(mesh, entities, dim, kind, log);
    check_closure(mesh, elements, entities, dim, kind, log);
  };
  check(mesh.edge_to_vert, mesh.edge_to_entity, 1, ElementKind::Edge);
  check(mesh.tri_to_vert, mesh.tri_to_entity, 2, ElementKind::Triangle);
  check(mesh.quad_to_vert, mesh.quad_to_entity, 2, ElementKind::Quad);
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto& entities) {
    check(cells, entities, 3, element_kind(kind));
  });
}

}  // namespace tetloom::detail
