#include "tetloom/check.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "core/mesh/curved_cell.hpp"
#include "core/mesh/curved_tet.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "core/mesh/validate_detail.hpp"
#include "core/predicates/predicates.hpp"

namespace tetloom {

std::string_view to_string(ProblemKind kind) {
  switch (kind) {
    case ProblemKind::ArrayLength: return "array_length";
    case ProblemKind::IndexOutOfRange: return "index_out_of_range";
    case ProblemKind::NonFinitePoint: return "non_finite_point";
    case ProblemKind::RepeatedVertex: return "repeated_vertex";
    case ProblemKind::DuplicateElement: return "duplicate_element";
    case ProblemKind::NonPositiveVolume: return "non_positive_volume";
    case ProblemKind::FaceUsedTooOften: return "face_used_too_often";
    case ProblemKind::OverlappingTets: return "overlapping_tets";
    case ProblemKind::BoundaryWithoutTriangle: return "boundary_without_triangle";
    case ProblemKind::InterfaceWithoutTriangle: return "interface_without_triangle";
    case ProblemKind::TriangleNotOnTets: return "triangle_not_on_tets";
    case ProblemKind::OpenBoundary: return "open_boundary";
    case ProblemKind::SidesDisagree: return "sides_disagree";
    case ProblemKind::FlippedTriangle: return "flipped_triangle";
    case ProblemKind::MissingEdge: return "missing_edge";
    case ProblemKind::EdgeNotOnTriangles: return "edge_not_on_triangles";
    case ProblemKind::ClassificationConflict: return "classification_conflict";
    case ProblemKind::EntityOutOfRange: return "entity_out_of_range";
    case ProblemKind::PartlyClassified: return "partly_classified";
    case ProblemKind::NonPositiveJacobian: return "non_positive_jacobian";
    case ProblemKind::FacesDoNotFit: return "faces_do_not_fit";
  }
  return "unknown";
}

std::string_view to_string(ElementKind kind) {
  static constexpr std::array<std::string_view, 8> names{"point", "edge",    "triangle", "tet",
                                                         "quad",  "pyramid", "prism",    "hex"};
  return names[static_cast<std::size_t>(kind)];
}

namespace {

constexpr std::size_t kShown = 8;

/// What was counted, with % for the plural of the kind of element.
std::string_view phrase(ProblemKind kind) {
  switch (kind) {
    case ProblemKind::ArrayLength: return "arrays of the wrong length";
    case ProblemKind::IndexOutOfRange: return "% that refer to points that are not there";
    case ProblemKind::NonFinitePoint: return "% with coordinates that are not finite";
    case ProblemKind::RepeatedVertex: return "% that use a point twice";
    case ProblemKind::DuplicateElement: return "% that repeat another one";
    case ProblemKind::NonPositiveVolume: return "% that are flat or inverted";
    case ProblemKind::FaceUsedTooOften: return "faces shared by three or more cells";
    case ProblemKind::OverlappingTets: return "faces with two cells on the same side";
    case ProblemKind::BoundaryWithoutTriangle: return "boundary faces of % without a triangle";
    case ProblemKind::InterfaceWithoutTriangle: return "faces of % between regions without a triangle";
    case ProblemKind::TriangleNotOnTets: return "% that are not a face of any cell";
    case ProblemKind::OpenBoundary: return "open edges in the boundary of the cells";
    case ProblemKind::SidesDisagree: return "% with other regions beside them than their model face has";
    case ProblemKind::FlippedTriangle: return "edges at which two % of a model face turn opposite ways";
    case ProblemKind::MissingEdge: return "places where model faces meet without a mesh edge";
    case ProblemKind::EdgeNotOnTriangles: return "% between surface points that are not on the surface";
    case ProblemKind::ClassificationConflict: return "% that contradict the classification of points";
    case ProblemKind::EntityOutOfRange: return "% on model entities that are not there";
    case ProblemKind::PartlyClassified: return "% without a model entity while others have one";
    case ProblemKind::NonPositiveJacobian: return "% of second order that are inverted somewhere";
    case ProblemKind::FacesDoNotFit: return "faces of % with four points against triangles";
  }
  return "%";
}

std::string plural_of(ElementKind kind) {
  return std::string(to_string(kind)) + (kind == ElementKind::Hex ? "es" : "s");
}

std::string message_for(const MeshProblem& problem) {
  std::string text(phrase(problem.kind));
  const std::size_t place = text.find('%');
  if (place != std::string::npos) text.replace(place, 1, plural_of(problem.element));
  const bool wants_surface =
      problem.kind == ProblemKind::BoundaryWithoutTriangle || problem.kind == ProblemKind::InterfaceWithoutTriangle;
  if (wants_surface && problem.element != ElementKind::Tet) text += " or quad";
  return text + ": " + std::to_string(problem.count);
}

template <class Elements>
void check_indices(const Mesh& mesh, const Elements& elements, ElementKind kind, const BlockLoop& loop,
                   detail::ProblemLog& log) {
  const auto is_missing = [&](std::uint32_t vertex) { return vertex >= mesh.points.size(); };
  detail::log_blocks(mesh, elements.size(), loop, log,
                     [&](std::size_t begin, std::size_t end, detail::ProblemLog& of_block) {
                       for (std::size_t i = begin; i < end; ++i)
                         if (std::any_of(elements[i].begin(), elements[i].end(), is_missing))
                           of_block.add(ProblemKind::IndexOutOfRange, kind, i);
                     });
}

/// Calls visit(kind, x_to_vert, x_to_entity) for edges, surface elements and cells.
template <class Visit>
void for_each_element_kind(const Mesh& mesh, const Visit& visit) {
  visit(ElementKind::Edge, mesh.edge_to_vert, mesh.edge_to_entity);
  visit(ElementKind::Triangle, mesh.tri_to_vert, mesh.tri_to_entity);
  visit(ElementKind::Quad, mesh.quad_to_vert, mesh.quad_to_entity);
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto& entities) {
    visit(detail::element_kind(kind), cells, entities);
  });
}

bool arrays_fit(const Mesh& mesh, const BlockLoop& loop, detail::ProblemLog& log) {
  const auto check = [&](std::size_t elements, std::size_t entities, const std::string& what) {
    if (elements == entities) return true;
    log.add_array(std::to_string(elements) + " " + what + " have " + std::to_string(entities) + " entities");
    return false;
  };
  bool fine = true;
  for_each_element_kind(mesh, [&](ElementKind kind, const auto& elements, const auto& entities) {
    fine &= check(elements.size(), entities.size(), plural_of(kind));
  });
  if (!mesh.point_to_entity.empty()) fine &= check(mesh.points.size(), mesh.point_to_entity.size(), "points");
  if (mesh.points.size() >= 0xffffffffu) log.add_array("the points are too many for 32-bit indices"), fine = false;
  if (!fine) return false;
  for_each_element_kind(mesh, [&](ElementKind kind, const auto& elements, const auto&) {
    check_indices(mesh, elements, kind, loop, log);
  });
  if (!log.empty()) return false;
  if (const auto fault = find_mid_node_fault(mesh, loop)) log.add_array(*fault);
  return log.empty();
}

void check_fields(const std::vector<MeshField>& fields, std::size_t carriers, const char* what,
                  detail::ProblemLog& log) {
  for (const MeshField& field : fields) {
    const auto components = static_cast<std::size_t>(std::max(field.components, 0));
    if (components > 0 && field.values.size() / components == carriers && field.values.size() % components == 0)
      continue;
    log.add_array("the field '" + field.name + "' has " + std::to_string(field.values.size()) +
                  " numbers in tuples of " + std::to_string(field.components) + " for " + std::to_string(carriers) +
                  " " + what);
  }
}

template <std::size_t N>
bool repeats_vertex(const std::array<std::uint32_t, N>& v) {
  for (std::size_t i = 0; i + 1 < N; ++i)
    for (std::size_t j = i + 1; j < N; ++j)
      if (v[i] == v[j]) return true;
  return false;
}

/// `finite` says that all points of the mesh are, which saves looking at those of the cell.
template <class Cell>
bool is_positive(const Mesh& mesh, CellKind kind, const Cell& cell, bool finite) {
  for (const std::uint32_t v : cell)
    if (!finite && !is_finite(mesh.points[v])) return false;
  for (const auto& [a, b, c, d] : corners_of(kind))
    if (orient3d(mesh.points[cell[a]], mesh.points[cell[b]], mesh.points[cell[c]], mesh.points[cell[d]]) <= 0)
      return false;
  return true;
}

bool all_finite(const Mesh& mesh, const BlockLoop& loop, detail::ProblemLog& log) {
  detail::ProblemLog found(mesh);
  detail::log_blocks(mesh, mesh.points.size(), loop, found,
                     [&](std::size_t begin, std::size_t end, detail::ProblemLog& of_block) {
                       for (std::size_t i = begin; i < end; ++i)
                         if (!is_finite(mesh.points[i]))
                           of_block.add(ProblemKind::NonFinitePoint, ElementKind::Point, i);
                     });
  const bool finite = found.empty();
  log.append(std::move(found));
  return finite;
}

void validate_shapes(const Mesh& mesh, const BlockLoop& loop, detail::ProblemLog& log) {
  const bool finite = all_finite(mesh, loop, log);
  for_each_element_kind(mesh, [&](ElementKind kind, const auto& elements, const auto&) {
    detail::log_blocks(mesh, elements.size(), loop, log,
                       [&](std::size_t begin, std::size_t end, detail::ProblemLog& of_block) {
                         for (std::size_t i = begin; i < end; ++i)
                           if (repeats_vertex(elements[i])) of_block.add(ProblemKind::RepeatedVertex, kind, i);
                       });
  });
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto&) {
    detail::log_blocks(mesh, cells.size(), loop, log,
                       [&](std::size_t begin, std::size_t end, detail::ProblemLog& of_block) {
                         for (std::size_t c = begin; c < end; ++c)
                           if (!is_positive(mesh, kind, cells[c], finite))
                             of_block.add(ProblemKind::NonPositiveVolume, detail::element_kind(kind), c);
                       });
  });
}

void validate_curved_cells(const Mesh& mesh, const BlockLoop& loop, detail::ProblemLog& log) {
  if (mesh.mid_to_vert.empty()) return;
  const MidNodes mids(mesh);
  const std::vector<std::uint8_t> is_end = ends_of_bent_edges(mesh);
  detail::log_blocks(mesh, mesh.tet_to_vert.size(), loop, log,
                     [&](std::size_t begin, std::size_t end, detail::ProblemLog& of_block) {
                       for (std::size_t t = begin; t < end; ++t)
                         if (has_two_of(mesh.tet_to_vert[t], is_end) && !is_straight_tet(mesh, mids, t) &&
                             !has_positive_jacobian(mesh, mids, t))
                           of_block.add(ProblemKind::NonPositiveJacobian, ElementKind::Tet, t);
                     });
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto&) {
    if (kind == CellKind::Tet) return;
    detail::log_blocks(mesh, cells.size(), loop, log,
                       [&](std::size_t begin, std::size_t end, detail::ProblemLog& of_block) {
                         for (std::size_t c = begin; c < end; ++c) {
                           if (!has_two_of(cells[c], is_end)) continue;
                           const CurvedCell cell = curved_cell_of(mesh, mids, kind, cells[c]);
                           if (!cell.is_straight() && !has_positive_jacobian(cell_jacobian(cell)))
                             of_block.add(ProblemKind::NonPositiveJacobian, detail::element_kind(kind), c);
                         }
                       });
  });
}

template <class Element>
void insert_vertices(std::span<const Element> elements, detail::PointSet& set) {
  for (const Element& element : elements)
    for (const std::uint32_t v : element) set.insert(v);
}

/// Marks all vertices of the elements. Each of a few shares of them has a set of its own at first.
template <class Element>
void mark_vertices(const std::vector<Element>& elements, const BlockLoop& loop, std::size_t points,
                   detail::PointSet& set) {
  constexpr std::size_t kShares = 32, kLeastShare = std::size_t{1} << 16, kWords = std::size_t{1} << 12;
  const std::size_t grain = std::max(kLeastShare, (elements.size() + kShares - 1) / kShares);
  if (elements.size() <= grain) return insert_vertices<Element>(elements, set);
  auto shares = map_blocks(loop, elements.size(), grain, detail::PointSet(0),
                           [&](std::size_t begin, std::size_t end, detail::PointSet& share) {
                             share = detail::PointSet(points);
                             insert_vertices(std::span(elements).subspan(begin, end - begin), share);
                           });
  loop.for_blocks(set.words().size(), kWords, [&](std::size_t begin, std::size_t end) {
    for (detail::PointSet& share : shares)
      for (std::size_t word = begin; word < end; ++word) set.words()[word] |= share.words()[word];
  });
}

/// Marks the points of the elements; counts the points that nothing uses.
detail::PointMarks mark_points(const Mesh& mesh, const BlockLoop& loop, ValidationReport& report) {
  const std::size_t count = vertex_count(mesh);
  detail::PointMarks marks{detail::PointSet(count), detail::PointSet(count), detail::PointSet(count)};
  for_each_element_kind(mesh, [&](ElementKind kind, const auto& elements, const auto&) {
    const bool is_surface = kind == ElementKind::Triangle || kind == ElementKind::Quad;
    mark_vertices(elements, loop, count, marks.used);
    if (is_surface) mark_vertices(elements, loop, count, marks.on_surface);
    if (kind == ElementKind::Edge) mark_vertices(elements, loop, count, marks.on_edge);
  });
  struct Counts {
    std::size_t unused = 0, unclassified = 0;
  };
  const auto found =
      map_blocks(loop, count, std::size_t{1} << 16, Counts{}, [&](std::size_t begin, std::size_t end, Counts& counts) {
        for (std::size_t i = begin; i < end; ++i) {
          counts.unused += !marks.used[i];
          counts.unclassified += marks.used[i] && !entity_of_point(mesh, i).valid();
        }
      });
  for (const Counts& counts : found) {
    report.unused_points += counts.unused;
    report.unclassified_points += counts.unclassified;
  }
  return marks;
}

}  // namespace

namespace detail {

void ProblemLog::add(ProblemKind kind, ElementKind element, std::uint64_t index) {
  for (MeshProblem& problem : problems_)
    if (problem.kind == kind && problem.element == element) {
      ++problem.count;
      if (problem.elements.size() < kShown) problem.elements.push_back(index);
      return;
    }
  problems_.push_back({kind, element, {}, 1, {index}, point_on(element, index)});
}

void ProblemLog::append(ProblemLog&& later) {
  for (MeshProblem& problem : later.problems_) {
    const auto same = std::find_if(problems_.begin(), problems_.end(), [&](const MeshProblem& own) {
      return own.kind == problem.kind && own.element == problem.element && own.message.empty();
    });
    if (same == problems_.end() || !problem.message.empty()) {
      problems_.push_back(std::move(problem));
      continue;
    }
    same->count += problem.count;
    for (const std::uint64_t index : problem.elements)
      if (same->elements.size() < kShown) same->elements.push_back(index);
  }
}

void ProblemLog::add_array(const std::string& message) {
  problems_.push_back({ProblemKind::ArrayLength, ElementKind::Point, message, 1, {}, {}});
}

std::optional<Vec3> ProblemLog::point_on(ElementKind element, std::uint64_t index) const {
  const auto centre = [&](const auto& vertices) {
    Vec3 sum;
    for (const std::size_t v : vertices) {
      if (v >= mesh_.points.size()) return std::optional<Vec3>{};
      sum += mesh_.points[v] / static_cast<double>(vertices.size());
    }
    return is_finite(sum) ? std::optional<Vec3>{sum} : std::optional<Vec3>{};
  };
  switch (element) {
    case ElementKind::Point: return centre(std::array<std::size_t, 1>{index});
    case ElementKind::Edge: return centre(mesh_.edge_to_vert[index]);
    case ElementKind::Triangle: return centre(mesh_.tri_to_vert[index]);
    case ElementKind::Tet: return centre(mesh_.tet_to_vert[index]);
    case ElementKind::Quad: return centre(mesh_.quad_to_vert[index]);
    case ElementKind::Pyramid: return centre(mesh_.pyramid_to_vert[index]);
    case ElementKind::Prism: return centre(mesh_.prism_to_vert[index]);
    case ElementKind::Hex: return centre(mesh_.hex_to_vert[index]);
  }
  return {};
}

std::vector<MeshProblem> ProblemLog::take() {
  for (MeshProblem& problem : problems_)
    if (problem.message.empty()) problem.message = message_for(problem);
  return std::move(problems_);
}

}  // namespace detail

ValidationReport validate_mesh(const Mesh& mesh, const BlockLoop& loop) {
  ValidationReport report;
  detail::ProblemLog log(mesh);
  if (arrays_fit(mesh, loop, log)) {
    validate_shapes(mesh, loop, log);
    validate_curved_cells(mesh, loop, log);
    const detail::PointMarks marks = mark_points(mesh, loop, report);
    detail::validate_faces(mesh, loop, log, report);
    detail::validate_surface_edges(mesh, marks, loop, log, report);
    detail::validate_classification(mesh, marks, loop, log);
    check_fields(mesh.point_fields, mesh.points.size(), "points", log);
    check_fields(mesh.cell_fields, cell_count(mesh), "cells", log);
  }
  report.problems = log.take();
  return report;
}

}  // namespace tetloom
