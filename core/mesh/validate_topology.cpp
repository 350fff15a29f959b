#include <utility>

#include "core/mesh/incidence_detail.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/validate_detail.hpp"

namespace tetloom::detail {
namespace {

ElementKind kind_of(const FaceUse& use) {
  if (use.owner() == FaceOwner::Triangle) return ElementKind::Triangle;
  if (use.owner() == FaceOwner::Quad) return ElementKind::Quad;
  return element_kind(use.cell().kind);
}

void log_use(ProblemLog& log, ProblemKind problem, const FaceUse& use) {
  log.add(problem, kind_of(use), use.element());
}

/// All elements that have the same points as a face.
struct FaceGroup {
  FacePoints points;
  std::vector<FaceUse> cells, surfaces;

  FaceGroup(const Mesh& mesh, std::span<const FaceUse> uses) : points(points_of(mesh, uses[0])) {
    for (const FaceUse& use : uses) (use.is_surface() ? surfaces : cells).push_back(use);
  }
  bool degenerate() const {
    for (std::size_t i = 0; i + 1 < points.size; ++i)
      for (std::size_t j = i + 1; j < points.size; ++j)
        if (points.cycle[i] == points.cycle[j]) return true;
    return false;
  }
};

std::uint32_t region_of(const Mesh& mesh, const FaceUse& use) { return tetloom::region_of(mesh, use.cell()); }

/// A vertex of the cell that is not on the face.
std::uint32_t vertex_off(const Mesh& mesh, const FaceUse& use) {
  if (use.owner() == FaceOwner::Tet) return mesh.tet_to_vert[use.element()][use.local_face()];
  const LocalFace& face = shape_of(use.cell().kind).faces()[static_cast<std::size_t>(use.local_face())];
  std::uint8_t v = 0;
  while (std::find(face.vertices().begin(), face.vertices().end(), v) != face.vertices().end()) ++v;
  return vertices_of(mesh, use.cell())[v];
}

/// Whether `uses` are those of nearly all faces: inside of a region, between two cells on different sides, which are
/// not the same cell inside out.
bool is_plain_interior(const Mesh& mesh, std::span<const FaceUse> uses) {
  if (uses.size() != 2 || uses[0].is_surface() || uses[1].is_surface() || uses[0].flipped() == uses[1].flipped() ||
      region_of(mesh, uses[0]) != region_of(mesh, uses[1]))
    return false;
  const std::span<const std::uint32_t> other = vertices_of(mesh, uses[1].cell());
  return std::find(other.begin(), other.end(), vertex_off(mesh, uses[0])) == other.end();
}

/// A cell by its vertices in ascending order.
struct CellKey {
  FaceOwner owner = FaceOwner::Tet;
  std::array<std::uint32_t, 8> vertices{};
  std::size_t element = 0;
  bool on_first_face = false;

  CellKey(const Mesh& mesh, const FaceUse& use)
      : owner(use.owner()), element(use.element()), on_first_face(use.local_face() == 0) {
    const std::span<const std::uint32_t> of_cell = vertices_of(mesh, use.cell());
    std::copy(of_cell.begin(), of_cell.end(), vertices.begin());
    std::sort(vertices.begin(), vertices.begin() + static_cast<std::ptrdiff_t>(of_cell.size()));
  }
  bool same_points(const CellKey& b) const { return owner == b.owner && vertices == b.vertices; }
  friend auto operator<=>(const CellKey&, const CellKey&) = default;
};

void check_cell_pairing(const Mesh& mesh, const FaceGroup& face, ProblemLog& log) {
  if (face.cells.size() < 2) return;
  std::vector<CellKey> keys;
  for (const FaceUse& use : face.cells) keys.emplace_back(mesh, use);
  std::sort(keys.begin(), keys.end());
  for (std::size_t i = 1; i < keys.size(); ++i)
    // Equal cells share all faces: the first one of the later cell stands for the pair.
    if (keys[i].same_points(keys[i - 1]) && keys[i].on_first_face)
      log.add(ProblemKind::DuplicateElement, element_kind(static_cast<CellKind>(keys[i].owner)), keys[i].element);
  if (face.cells.size() > 2) log_use(log, ProblemKind::FaceUsedTooOften, face.cells[2]);
  if (face.cells.size() == 2 && face.cells[0].flipped() == face.cells[1].flipped() && !keys[0].same_points(keys[1]))
    log_use(log, ProblemKind::OverlappingTets, face.cells[1]);
}

/// The sides of the model face of a surface element, or null where they are unknown.
const FaceSides* sides_of(const Mesh& mesh, const FaceUse& use) {
  const auto& entities = use.owner() == FaceOwner::Quad ? mesh.quad_to_entity : mesh.tri_to_entity;
  const std::uint32_t face = entities[use.element()];
  return face < mesh.face_to_sides.size() ? &mesh.face_to_sides[face] : nullptr;
}

//   outward normal of the cell below     a cell whose outward orientation of the face is that of the surface element
//        ^   ^ normal of the element     lies behind it, one with the opposite orientation in front of it
//   -----|---|-----  face
//       cell
void check_sides(const Mesh& mesh, const FaceGroup& face, ProblemLog& log) {
  const FaceUse& surface = face.surfaces[0];
  const FaceSides* sides = sides_of(mesh, surface);
  if (sides == nullptr || face.cells.size() > 2) return;
  FaceSides found;
  for (const FaceUse& use : face.cells)
    (use.flipped() == surface.flipped() ? found.back : found.front).value = region_of(mesh, use);
  if (found.front != sides->front || found.back != sides->back) log_use(log, ProblemKind::SidesDisagree, surface);
}

void check_surfaces(const Mesh& mesh, const FaceGroup& face, ProblemLog& log) {
  for (std::size_t i = 1; i < face.surfaces.size(); ++i) log_use(log, ProblemKind::DuplicateElement, face.surfaces[i]);
  if (face.surfaces.empty() || cell_count(mesh) == 0) return;
  if (!face.cells.empty()) return check_sides(mesh, face, log);
  const FaceSides* sides = sides_of(mesh, face.surfaces[0]);
  const bool is_sheet = sides != nullptr && !sides->front.valid() && !sides->back.valid();
  if (!is_sheet) log_use(log, ProblemKind::TriangleNotOnTets, face.surfaces[0]);
}

using Triangle = std::array<std::uint32_t, 3>;

Triangle sorted(Triangle v) {
  std::sort(v.begin(), v.end());
  return v;
}

/// The faces of single cells.
struct Boundary {
  std::vector<ElementEdge> edges;
  std::vector<Triangle> triangles;  // kept in meshes that have faces of four points
  std::vector<FaceUse> quads;

  void add(const FaceGroup& face, bool keeps_triangles) {
    const FaceUse& use = face.cells[0];
    const auto& [size, cycle] = face.points;
    const std::uint64_t element = use.element() * 4 + static_cast<std::uint64_t>(use.owner());
    for (std::size_t i = 0; i < size; ++i) edges.push_back(make_edge_use(cycle[i], cycle[(i + 1) % size], element));
    if (size == 4) quads.push_back(use);
    if (size == 3 && keeps_triangles) triangles.push_back(sorted({cycle[0], cycle[1], cycle[2]}));
  }
  void append(const Boundary& other) {
    edges.insert(edges.end(), other.edges.begin(), other.edges.end());
    triangles.insert(triangles.end(), other.triangles.begin(), other.triangles.end());
    quads.insert(quads.end(), other.quads.begin(), other.quads.end());
  }
};

/// What is found at the faces around a range of points.
struct FaceFindings {
  ProblemLog log;
  Boundary boundary;
  std::size_t boundary_faces = 0, interface_faces = 0;
};

void check_face(const Mesh& mesh, const FaceGroup& face, bool keeps_triangles, FaceFindings& findings) {
  check_cell_pairing(mesh, face, findings.log);
  check_surfaces(mesh, face, findings.log);
  const bool lacks_surface = surface_count(mesh) > 0 && face.surfaces.empty();
  if (face.cells.size() == 1) {
    ++findings.boundary_faces;
    if (lacks_surface) log_use(findings.log, ProblemKind::BoundaryWithoutTriangle, face.cells[0]);
    findings.boundary.add(face, keeps_triangles);
  } else if (face.cells.size() == 2 && region_of(mesh, face.cells[0]) != region_of(mesh, face.cells[1])) {
    ++findings.interface_faces;
    if (lacks_surface) log_use(findings.log, ProblemKind::InterfaceWithoutTriangle, face.cells[0]);
  }
}

void count_edges(const Mesh& mesh, const std::vector<ElementEdge>& uses, const BlockLoop& loop, ProblemLog& log,
                 ValidationReport& report) {
  const auto emit = [&](std::size_t begin, std::size_t end, const auto& add) {
    for (std::size_t i = begin; i < end; ++i) add(uses[i]);
  };
  const auto visit = [](std::span<const ElementEdge> group, EdgeFindings& findings) {
    if (group.size() > 2) ++findings.nonmanifold;
    if (group.size() % 2 == 0) return;
    ++findings.open;
    findings.log.add(ProblemKind::OpenBoundary, element_kind(static_cast<CellKind>(group[0].element() % 4)),
                     group[0].element() / 4);
  };
  check_edge_groups(mesh, uses.size(), loop, emit, visit, log, report);
}

//   d-----c   a face of four points fits only onto another one, not onto two triangles, although these close the
//   |   / |   gap as far as edges can tell
//   | /   |
//   a-----b
void find_misfits(const Mesh& mesh, Boundary& boundary, const BlockLoop& loop, ProblemLog& log) {
  std::vector<Triangle>& triangles = boundary.triangles;
  std::sort(triangles.begin(), triangles.end());
  log_blocks(mesh, boundary.quads.size(), loop, log, [&](std::size_t begin, std::size_t end, ProblemLog& of_block) {
    for (std::size_t q = begin; q < end; ++q) {
      const auto [a, b, c, d] = points_of(mesh, boundary.quads[q]).cycle;
      for (const Triangle& half : {Triangle{a, b, c}, {a, c, d}, {a, b, d}, {b, c, d}})
        if (std::binary_search(triangles.begin(), triangles.end(), sorted(half))) {
          log_use(of_block, ProblemKind::FacesDoNotFit, boundary.quads[q]);
          break;
        }
    }
  });
}

}  // namespace

void validate_faces(const Mesh& mesh, const BlockLoop& loop, ProblemLog& log, ValidationReport& report) {
  const bool keeps_triangles = cell_count(mesh) > mesh.tet_to_vert.size();
  const auto visit = [&](std::uint32_t, std::span<const FaceUse> uses, FaceFindings& findings) {
    if (is_plain_interior(mesh, uses)) return;
    const FaceGroup face(mesh, uses);
    if (!face.degenerate()) check_face(mesh, face, keeps_triangles, findings);
  };
  Boundary boundary;
  for (FaceFindings& found : map_face_groups(mesh, loop, FaceFindings{ProblemLog(mesh), {}}, visit)) {
    log.append(std::move(found.log));
    boundary.append(found.boundary);
    report.boundary_faces += found.boundary_faces;
    report.interface_faces += found.interface_faces;
  }
  count_edges(mesh, boundary.edges, loop, log, report);
  find_misfits(mesh, boundary, loop, log);
}

}  // namespace tetloom::detail
