#include <utility>

#include "core/mesh/incidence_detail.hpp"
#include "core/mesh/validate_detail.hpp"

namespace tetloom::detail {
namespace {

/// All elements that have the same three points as a face.
struct FaceGroup {
  std::array<std::uint32_t, 3> points;  // ascending
  std::vector<FaceUse> tets, triangles;

  FaceGroup(std::uint32_t low, std::span<const FaceUse> uses) : points{low, uses[0].mid, uses[0].high} {
    for (const FaceUse& use : uses) (use.is_triangle() ? triangles : tets).push_back(use);
  }
  bool degenerate() const { return points[0] == points[1] || points[1] == points[2]; }
};

std::uint32_t region_of(const Mesh& mesh, const FaceUse& tet) { return mesh.tet_to_entity[tet.element()]; }
std::uint32_t opposite_of(const Mesh& mesh, const FaceUse& tet) {
  return mesh.tet_to_vert[tet.element()][tet.local_face()];
}

/// Whether `uses` are those of nearly all faces: inside of a region, between two tets on different sides.
bool is_plain_interior(const Mesh& mesh, std::span<const FaceUse> uses) {
  return uses.size() == 2 && !uses[0].is_triangle() && !uses[1].is_triangle() &&
         uses[0].flipped() != uses[1].flipped() && region_of(mesh, uses[0]) == region_of(mesh, uses[1]) &&
         opposite_of(mesh, uses[0]) != opposite_of(mesh, uses[1]);
}

void check_tet_pairing(const Mesh& mesh, const FaceGroup& face, ProblemLog& log) {
  if (face.tets.size() < 2) return;
  std::vector<std::pair<std::uint32_t, std::size_t>> apexes;
  for (const FaceUse& tet : face.tets) apexes.emplace_back(opposite_of(mesh, tet), tet.element());
  std::sort(apexes.begin(), apexes.end());
  for (std::size_t i = 1; i < apexes.size(); ++i)
    // Equal tets share all four faces: the one without their largest point stands for the pair.
    if (apexes[i].first == apexes[i - 1].first && apexes[i].first > face.points[2])
      log.add(ProblemKind::DuplicateElement, ElementKind::Tet, apexes[i].second);
  if (face.tets.size() > 2) log.add(ProblemKind::FaceUsedTooOften, ElementKind::Tet, face.tets[2].element());
  if (face.tets.size() == 2 && face.tets[0].flipped() == face.tets[1].flipped() && apexes[0].first != apexes[1].first)
    log.add(ProblemKind::OverlappingTets, ElementKind::Tet, face.tets[1].element());
}

/// The sides of the model face of triangle `t`, or null where they are unknown.
const FaceSides* sides_of(const Mesh& mesh, std::size_t t) {
  const std::uint32_t face = mesh.tri_to_entity[t];
  return face < mesh.face_to_sides.size() ? &mesh.face_to_sides[face] : nullptr;
}

//   outward normal of the tet below      a tet whose outward orientation of the face is that of the triangle lies
//        ^   ^ normal of the triangle    behind the triangle, one with the opposite orientation in front of it
//   -----|---|-----  face
//       tet
void check_sides(const Mesh& mesh, const FaceGroup& face, ProblemLog& log) {
  const FaceUse& triangle = face.triangles[0];
  const FaceSides* sides = sides_of(mesh, triangle.element());
  if (sides == nullptr || face.tets.size() > 2) return;
  FaceSides found;
  for (const FaceUse& tet : face.tets)
    (tet.flipped() == triangle.flipped() ? found.back : found.front).value = region_of(mesh, tet);
  if (found.front != sides->front || found.back != sides->back)
    log.add(ProblemKind::SidesDisagree, ElementKind::Triangle, triangle.element());
}

void check_triangles(const Mesh& mesh, const FaceGroup& face, ProblemLog& log) {
  for (std::size_t i = 1; i < face.triangles.size(); ++i)
    log.add(ProblemKind::DuplicateElement, ElementKind::Triangle, face.triangles[i].element());
  if (face.triangles.empty() || mesh.tet_to_vert.empty()) return;
  const std::size_t triangle = face.triangles[0].element();
  if (!face.tets.empty()) return check_sides(mesh, face, log);
  const FaceSides* sides = sides_of(mesh, triangle);
  const bool is_sheet = sides != nullptr && !sides->front.valid() && !sides->back.valid();
  if (!is_sheet) log.add(ProblemKind::TriangleNotOnTets, ElementKind::Triangle, triangle);
}

void count_boundary_edges(std::vector<EdgeUse>& uses, ProblemLog& log, ValidationReport& report) {
  for_each_edge_group(uses, [&](std::span<const EdgeUse> group) {
    if (group.size() > 2) ++report.nonmanifold_edges;
    if (group.size() % 2 == 0) return;
    ++report.open_edges;
    log.add(ProblemKind::OpenBoundary, ElementKind::Tet, group[0].element());
  });
}

/// All triangles and mesh edges that join the same two points.
struct SurfaceEdge {
  std::size_t triangles = 0, mesh_edges = 0;
  bool faces_differ = false;
  const EdgeUse* first = nullptr;  // triangles
  const EdgeUse* second = nullptr;

  SurfaceEdge(const Mesh& mesh, std::span<const EdgeUse> group) {
    for (const EdgeUse& use : group) {
      if (use.is_mesh_edge()) {
        ++mesh_edges;
        continue;
      }
      ++triangles;
      if (first == nullptr) {
        first = &use;
      } else {
        second = &use;
        faces_differ |= mesh.tri_to_entity[use.element()] != mesh.tri_to_entity[first->element()];
      }
    }
  }
};

void check_surface_edge(const Mesh& mesh, const PointMarks& marks, std::span<const EdgeUse> group, ProblemLog& log) {
  const SurfaceEdge edge(mesh, group);
  std::size_t seen = 0;
  for (const EdgeUse& use : group)
    if (use.is_mesh_edge() && seen++ > 0) log.add(ProblemKind::DuplicateElement, ElementKind::Edge, use.element());
  if (edge.triangles == 0) {
    const bool on_surface = marks.on_triangle[group[0].low] && marks.on_triangle[group[0].high];
    if (on_surface) log.add(ProblemKind::EdgeNotOnTriangles, ElementKind::Edge, group[0].element());
    return;
  }
  const std::uint32_t face = mesh.tri_to_entity[edge.first->element()];
  if (face == ModelFaceId::kNone) return;
  if (edge.triangles == 2 && !edge.faces_differ && edge.first->reversed() == edge.second->reversed())
    log.add(ProblemKind::FlippedTriangle, ElementKind::Triangle, edge.second->element());
  if (edge.faces_differ && edge.mesh_edges == 0 && !mesh.edge_to_vert.empty())
    log.add(ProblemKind::MissingEdge, ElementKind::Triangle, edge.first->element());
}

}  // namespace

void validate_faces(const Mesh& mesh, ProblemLog& log, ValidationReport& report) {
  std::vector<EdgeUse> boundary_edges;
  const bool has_triangles = !mesh.tri_to_vert.empty();
  for_each_face_group(mesh, [&](std::uint32_t low, std::span<const FaceUse> uses) {
    if (is_plain_interior(mesh, uses)) return;
    const FaceGroup face(low, uses);
    if (face.degenerate()) return;
    check_tet_pairing(mesh, face, log);
    check_triangles(mesh, face, log);
    const bool lacks_triangle = has_triangles && face.triangles.empty();
    if (face.tets.size() == 1) {
      const std::size_t tet = face.tets[0].element();
      const auto [a, b, c] = face.points;
      ++report.boundary_faces;
      if (lacks_triangle) log.add(ProblemKind::BoundaryWithoutTriangle, ElementKind::Tet, tet);
      for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{a, c}})
        boundary_edges.push_back(make_edge_use(from, to, tet));
    } else if (face.tets.size() == 2 && region_of(mesh, face.tets[0]) != region_of(mesh, face.tets[1])) {
      ++report.interface_faces;
      if (lacks_triangle) log.add(ProblemKind::InterfaceWithoutTriangle, ElementKind::Tet, face.tets[0].element());
    }
  });
  count_boundary_edges(boundary_edges, log, report);
}

void validate_surface_edges(const Mesh& mesh, const PointMarks& marks, ProblemLog& log, ValidationReport& report) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * mesh.tri_to_vert.size() + mesh.edge_to_vert.size());
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t)
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t from = mesh.tri_to_vert[t][i], to = mesh.tri_to_vert[t][(i + 1) % 3];
      if (from != to) uses.push_back(make_edge_use(from, to, t));
    }
  for (std::size_t e = 0; e < mesh.edge_to_vert.size(); ++e)
    uses.push_back(make_edge_use(mesh.edge_to_vert[e][0], mesh.edge_to_vert[e][1], e, true));
  for_each_edge_group(uses, [&](std::span<const EdgeUse> group) {
    check_surface_edge(mesh, marks, group, log);
    if (!mesh.tet_to_vert.empty()) return;
    const SurfaceEdge edge(mesh, group);
    report.open_edges += edge.triangles % 2;
    report.nonmanifold_edges += edge.triangles > 2;
  });
}

}  // namespace tetloom::detail
