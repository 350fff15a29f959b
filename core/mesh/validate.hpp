#pragma once
// The executable invariant of a mesh, of tetloom's or anybody else's.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/mesh.hpp"

namespace tetloom {

enum class ProblemKind {
  ArrayLength,               ///< an array that must be as long as another is not
  IndexOutOfRange,           ///< an element refers to a point that is not there
  NonFinitePoint,            ///< a coordinate is infinite or not a number
  RepeatedVertex,            ///< an element uses a point twice
  DuplicateElement,          ///< two elements of a kind have the same points
  NonPositiveVolume,         ///< a tet is flat or inverted (exact sign)
  FaceUsedTooOften,          ///< three or more tets share a face
  OverlappingTets,           ///< two tets lie on the same side of their common face
  BoundaryWithoutTriangle,   ///< a face of a single tet has no triangle although the mesh has triangles
  InterfaceWithoutTriangle,  ///< two tets of different regions meet, without a triangle between them
  TriangleNotOnTets,         ///< a triangle that bounds a region is not a face of any tet
  OpenBoundary,              ///< the boundary of the tets is not watertight
  SidesDisagree,             ///< the regions beside a triangle are not those of its model face
  FlippedTriangle,           ///< two neighbouring triangles of a model face turn opposite ways
  MissingEdge,               ///< model faces meet between two triangles, without a mesh edge there
  EdgeNotOnTriangles,        ///< an edge between surface points is not an edge of any triangle
  ClassificationConflict,    ///< a point cannot lie on the entity that it is classified on
  EntityOutOfRange,          ///< an entity index beyond the mesh's own table of entities
  PartlyClassified           ///< some elements of a kind are classified, others are not
};

/// A stable name in snake case, for reports.
std::string_view to_string(ProblemKind kind);

enum class ElementKind { Point, Edge, Triangle, Tet };

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
  std::size_t boundary_faces = 0;       ///< faces of exactly one tet
  std::size_t interface_faces = 0;      ///< faces between tets of different regions
  std::size_t open_edges = 0;           ///< edges used by an odd number of boundary faces, or of triangles without tets
  std::size_t nonmanifold_edges = 0;    ///< edges used by more than two of them

  bool valid() const { return problems.empty(); }
};

/// Checks everything that can be checked without the model. Where arrays or indices are broken the checks that rely
/// on them are left out.
///
/// Checked: array lengths; index ranges; finite coordinates; repeated vertices; duplicate elements; exact positive
/// volumes; every tet face in one or two tets that lie on different sides of it; a watertight boundary; triangles,
/// where there are any, on exactly the faces that bound a region, agreeing with `face_to_sides`; triangles of a face
/// turned alike; mesh edges, where there are any, wherever model faces meet; points classified on the closure of what
/// their elements lie on. A surface without tets may be open: that is reported in `open_edges`, not as a problem.
/// Meshes without classification (invalid entities throughout) pass; the checks that need it do not apply.
///
/// Complexity: linear but for sorting around each vertex; 128 MiB of working memory, 5 bytes per point and some 100
/// bytes per triangle of the surface. Never throws for a bad mesh.
/// Thread safety: pure.
ValidationReport validate_mesh(const Mesh& mesh);

}  // namespace tetloom
