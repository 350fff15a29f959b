#pragma once
// The executable invariant of a mesh, of tetloom's or anybody else's.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/block_loop.hpp"
#include "core/mesh/mesh.hpp"

namespace tetloom {

/// Surface elements are triangles and quadrilaterals, cells are tets, pyramids, prisms and hexes. (The names are older
/// than the cells other than tets.)
enum class ProblemKind {
  ArrayLength,               ///< an array that must be as long as another is not
  IndexOutOfRange,           ///< an element refers to a point that is not there
  NonFinitePoint,            ///< a coordinate is infinite or not a number
  RepeatedVertex,            ///< an element uses a point twice
  DuplicateElement,          ///< two elements of a kind have the same points
  NonPositiveVolume,         ///< a cell is flat or inverted at a corner (exact sign)
  FaceUsedTooOften,          ///< three or more cells share a face
  OverlappingTets,           ///< two cells lie on the same side of their common face
  BoundaryWithoutTriangle,   ///< a face of a single cell has no surface element although the mesh has some
  InterfaceWithoutTriangle,  ///< two cells of different regions meet, without a surface element between them
  TriangleNotOnTets,         ///< a surface element that bounds a region is not a face of any cell
  OpenBoundary,              ///< the boundary of the cells is not watertight
  SidesDisagree,             ///< the regions beside a surface element are not those of its model face
  FlippedTriangle,           ///< two neighbouring surface elements of a model face turn opposite ways
  MissingEdge,               ///< model faces meet between two surface elements, without a mesh edge there
  EdgeNotOnTriangles,        ///< an edge between surface points is not an edge of any surface element
  ClassificationConflict,    ///< a point cannot lie on the entity that it is classified on
  EntityOutOfRange,          ///< an entity index beyond the mesh's own table of entities
  PartlyClassified,          ///< some elements of a kind are classified, others are not
  FacesDoNotFit              ///< a face of four points lies against a triangular face of another cell
};

/// A stable name in snake case, for reports.
std::string_view to_string(ProblemKind kind);

enum class ElementKind { Point, Edge, Triangle, Tet, Quad, Pyramid, Prism, Hex };

std::string_view to_string(ElementKind kind);

/// All problems of one kind on one kind of element.
struct MeshProblem {
  ProblemKind kind = ProblemKind::ArrayLength;
  ElementKind element = ElementKind::Point;
  std::string message;                  ///< one sentence with the count
  std::size_t count = 0;                ///< how many there are in all
  std::vector<std::uint64_t> elements;  ///< the first few, 0-based
  std::optional<Vec3> point;            ///< on the first of them
};

struct ValidationReport {
  std::vector<MeshProblem> problems;

  // What was seen on the way; none of it is an error.
  std::size_t unused_points = 0;        ///< points that no element uses
  std::size_t unclassified_points = 0;  ///< used points without a model entity
  std::size_t boundary_faces = 0;       ///< faces of exactly one cell
  std::size_t interface_faces = 0;      ///< faces between cells of different regions
  std::size_t open_edges = 0;         ///< edges used by an odd number of boundary faces, or of a surface without cells
  std::size_t nonmanifold_edges = 0;  ///< edges used by more than two of them

  bool valid() const { return problems.empty(); }
};

/// Checks everything that can be checked without the model. Where arrays or indices are broken the checks that rely
/// on them are left out.
///
/// Checked: array lengths, those of fields too; index ranges; finite coordinates; repeated vertices; duplicate
/// elements; exact positive volumes at all corners (`CellShape::corners`); every face of a cell in one or two cells
/// that lie on different sides of it, quadrilaterals in the same cycle and not against triangles; a watertight
/// boundary; surface elements, where there are any, on exactly the faces that bound a region, agreeing with
/// `face_to_sides`; those of a face turned alike; mesh edges, where there are any, wherever model faces meet; points
/// classified on the closure of what their elements lie on. A surface without cells may be open: that is reported in
/// `open_edges`, not as a problem. Meshes without classification (invalid entities throughout) pass; the checks that
/// need it do not apply.
///
/// Complexity: linear but for sorting around each vertex; 128 MiB of working memory, 5 bytes per point and some 130
/// bytes per triangle or quadrilateral of the surface. `loop` carries out the work; the report does not depend on it.
/// Never throws for a bad mesh. Thread safety: pure.
ValidationReport validate_mesh(const Mesh& mesh, const BlockLoop& loop = serial_loop());

}  // namespace tetloom
