#include "core/mesh/mesh_access.hpp"
#include "core/mesh/validate_detail.hpp"

namespace tetloom::detail {
namespace {

// Surface elements are numbered triangles first, then quadrilaterals.

std::uint32_t surface_entity(const Mesh& mesh, std::size_t element) {
  const std::size_t triangles = mesh.tri_to_entity.size();
  return element < triangles ? mesh.tri_to_entity[element] : mesh.quad_to_entity[element - triangles];
}

void log_surface(const Mesh& mesh, ProblemLog& log, ProblemKind problem, std::size_t element) {
  const std::size_t triangles = mesh.tri_to_entity.size();
  if (element < triangles)
    log.add(problem, ElementKind::Triangle, element);
  else
    log.add(problem, ElementKind::Quad, element - triangles);
}

/// All surface elements and mesh edges that join the same two points.
struct SurfaceEdge {
  std::size_t faces = 0, mesh_edges = 0;
  bool faces_differ = false;
  const ElementEdge* first = nullptr;  // surface elements
  const ElementEdge* second = nullptr;

  SurfaceEdge(const Mesh& mesh, std::span<const ElementEdge> group) {
    for (const ElementEdge& use : group) {
      if (use.is_mesh_edge()) {
        ++mesh_edges;
        continue;
      }
      ++faces;
      if (first == nullptr) {
        first = &use;
      } else {
        second = &use;
        faces_differ |= surface_entity(mesh, use.element()) != surface_entity(mesh, first->element());
      }
    }
  }
};

void check_surface_edge(const Mesh& mesh, const PointMarks& marks, std::span<const ElementEdge> group,
                        ProblemLog& log) {
  const SurfaceEdge edge(mesh, group);
  std::size_t seen = 0;
  for (const ElementEdge& use : group)
    if (use.is_mesh_edge() && seen++ > 0) log.add(ProblemKind::DuplicateElement, ElementKind::Edge, use.element());
  if (edge.faces == 0) {
    const bool on_surface = marks.on_surface[group[0].low] && marks.on_surface[group[0].high];
    if (on_surface) log.add(ProblemKind::EdgeNotOnTriangles, ElementKind::Edge, group[0].element());
    return;
  }
  const std::uint32_t face = surface_entity(mesh, edge.first->element());
  if (face == ModelFaceId::kNone) return;
  if (edge.faces == 2 && !edge.faces_differ && edge.first->reversed() == edge.second->reversed())
    log_surface(mesh, log, ProblemKind::FlippedTriangle, edge.second->element());
  if (edge.faces_differ && edge.mesh_edges == 0 && !mesh.edge_to_vert.empty())
    log_surface(mesh, log, ProblemKind::MissingEdge, edge.first->element());
}

}  // namespace

void validate_surface_edges(const Mesh& mesh, const PointMarks& marks, const BlockLoop& loop, ProblemLog& log,
                            ValidationReport& report) {
  const std::size_t triangles = mesh.tri_to_vert.size(), surfaces = surface_count(mesh);
  const auto emit = [&](std::size_t begin, std::size_t end, const auto& add) {
    const auto add_surface = [&](const auto& v, std::size_t number) {
      for (std::size_t i = 0; i < v.size(); ++i) {
        const std::uint32_t from = v[i], to = v[(i + 1) % v.size()];
        if (from != to) add(make_edge_use(from, to, number));
      }
    };
    for (std::size_t i = begin; i < end; ++i) {
      if (i < triangles) {
        add_surface(mesh.tri_to_vert[i], i);
      } else if (i < surfaces) {
        add_surface(mesh.quad_to_vert[i - triangles], i);
      } else {
        const auto& [from, to] = mesh.edge_to_vert[i - surfaces];
        add(make_edge_use(from, to, i - surfaces, true));
      }
    }
  };
  const bool counts_edges = cell_count(mesh) == 0;
  const auto visit = [&](std::span<const ElementEdge> group, EdgeFindings& findings) {
    check_surface_edge(mesh, marks, group, findings.log);
    if (!counts_edges) return;
    const SurfaceEdge edge(mesh, group);
    findings.open += edge.faces % 2;
    findings.nonmanifold += edge.faces > 2;
  };
  check_edge_groups(mesh, surfaces + mesh.edge_to_vert.size(), loop, emit, visit, log, report);
}

}  // namespace tetloom::detail
