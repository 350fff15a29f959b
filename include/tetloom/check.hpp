#pragma once
// What can be said about any mesh: whether it is valid, how good it is, and a fingerprint.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/size_field.hpp"

// The executable invariant of a mesh, of tetloom's or anybody else's.

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
  NonPositiveJacobian,       ///< a tet of second order whose Jacobian is not proven to be positive everywhere
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

/// What is wrong with a mesh.
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
/// elements; exact positive volumes at all corners (`CellShape::corners`); positive Jacobians of tets of second order;
/// every face of a cell in one or two cells that lie on different sides of it, quadrilaterals in the same cycle and not
/// against triangles; a watertight boundary; surface elements, where there are any, on exactly the faces that bound a
/// region, agreeing with `face_to_sides`; those of a face turned alike; mesh edges, where there are any, wherever model
/// faces meet; points classified on the closure of what their elements lie on. A surface without cells may be open:
/// that is reported in `open_edges`, not as a problem. Meshes without classification (invalid entities throughout)
/// pass; the checks that need it do not apply.
///
/// Complexity: linear but for sorting around each vertex; 128 MiB of working memory, 5 bytes per point and some 130
/// bytes per triangle or quadrilateral of the surface. `loop` carries out the work; the report does not depend on it.
/// Never throws for a bad mesh. Thread safety: pure.
ValidationReport validate_mesh(const Mesh& mesh, const BlockLoop& loop = serial_loop());

// How good a mesh is: shapes of its elements, and how well its edges keep to the sizes asked for.

/// Edge lengths divided by the size asked for; every unique edge counts once. Zeros where no size field was given.
struct EdgeConformity {
  std::size_t edges = 0;         ///< unique edges of the elements
  double mean_length = 0;        ///< model length
  double mean_length_ratio = 0;  ///< mean of length / size; the size is the mean of those at the edge's ends
  double in_band = 0;            ///< share of edges with length / size in [0.707106781, 1.41421356]
};

/// Of the cells of one model region.
struct RegionQuality {
  std::uint32_t region = 0;  ///< index of the model region; Id::kNone for unclassified cells
  std::size_t tets = 0;
  std::size_t cells = 0;  ///< of all kinds, tets as well
  double volume = 0;      ///< of all of them
};

/// Cells of all kinds together.
struct CellQuality {
  std::array<std::size_t, kCellKinds> counts{};  ///< by CellKind
  std::size_t count = 0;                         ///< of all kinds
  std::size_t inverted = 0;                      ///< cells that are not positive at all corners (exact sign)
  double volume = 0;                             ///< sum of signed volumes; faces of four points are bilinear
  double min_scaled_jacobian = 1;  ///< over the corners of pyramids, prisms and hexahedra: the Jacobian divided by the
                                   ///< lengths of the edges there; 1 at best, and without such cells
  double scaled_jacobian_p1 = 1;   ///< first percentile of the cells' least one, interpolated linearly
  std::vector<RegionQuality> regions;  ///< ascending by region
};

/// Of all tets.
struct TetQuality {
  std::size_t count = 0;
  std::size_t inverted = 0;     ///< tets whose exact volume is not positive
  double min_dihedral_deg = 0;  ///< smallest angle between two faces of a tet; 0 as soon as one tet is inverted
  double mean_ratio_min = 0;    ///< mean ratio: 12 (3V)^(2/3) / sum of squared edges; 1 regular, 0 flat or inverted
  double mean_ratio_p1 = 0;     ///< first percentile, interpolated linearly
  double mean_ratio_mean = 0;
  double volume = 0;                                   ///< sum of signed volumes of the tets alone
  std::array<std::size_t, 10> mean_ratio_histogram{};  ///< bins of width 0.1; 1 falls into the last
  std::array<std::size_t, 18>
      dihedral_histogram{};  ///< six angles of every tet that is not inverted, bins of 10 degrees
  EdgeConformity edges;
};

/// Of the triangles on one model face.
struct FaceQuality {
  std::uint32_t face = 0;  ///< index of the model face; Id::kNone for unclassified triangles
  std::size_t triangles = 0;
  double area = 0;
  double min_angle_deg = 0;
};

/// Of all triangles.
struct TriangleQuality {
  std::size_t count = 0;
  double shape_min = 0;  ///< 4 sqrt(3) A / sum of squared edges; 1 equilateral, 0 flat
  double shape_p1 = 0;   ///< first percentile, interpolated linearly
  double shape_mean = 0;
  double min_angle_deg = 0;  ///< smallest corner angle
  double area = 0;
  EdgeConformity edges;
  std::vector<FaceQuality> faces;  ///< ascending by face
};

/// Cells of second order. Those of a mesh of first order are straight.
struct CurvedQuality {
  std::size_t count = 0;           ///< cells with a mid node beside the middle of its edge
  std::size_t not_positive = 0;    ///< those whose Jacobian is not proven to be positive everywhere
  double min_scaled_jacobian = 1;  ///< the least Jacobian of all cells, over the least of the straight one; a bound
                                   ///< within .001, by Bézier coefficients (Johnen, Remacle & Geuzaine 2013)
  double volume = 0;               ///< of all cells, the straight ones as well; exact but for rounding
};

/// All fields of a kind of element that the mesh does not have are zero.
struct QualityReport {
  CellQuality cells;
  TetQuality tets;
  TriangleQuality triangles;
  CurvedQuality curved;
};

/// Measures `mesh`: shapes and edges of tets and triangles, and how many cells of any kind there are and how much space
/// they fill. `sizes` may be null: then only lengths are measured, not their ratio to a size.
/// Pre: indices lie in range and arrays have matching lengths (see `validate_mesh`); orientation and classification
/// may be anything. Throws Error(InvalidArgument) otherwise.
/// Complexity: linear; one size query per point; about 4 bytes per tet, 8 per point and 128 MiB of working memory.
/// `loop` carries out the work; no bit of the result depends on it. Thread safety: may be called from any thread.
QualityReport compute_quality(const Mesh& mesh, const SizeField* sizes = nullptr,
                              const BlockLoop& loop = serial_loop());

// A fingerprint of a mesh that does not depend on how it is stored.

/// 32 hexadecimal digits over the coordinates (bit for bit, but -0 equals +0), the connectivity and the classification
/// of everything in `mesh`.
///
/// Laws: unchanged when points or elements are renumbered, and when the vertices of an element are permuted as a
/// rotation does it (evenly, for triangles and tets); one that turns the element over changes the digest. Any other
/// change of a coordinate, a connection or a classification changes it. Names, colours, face sides and fields do not
/// count. A mesh of edges, triangles and tets of first order has the digest that it had before there were others.
/// Not guaranteed: two points that agree in coordinates and in classification are not told apart by the elements that
/// use them, and the digest resists accidents, not attackers.
///
/// SipHash-2-4 with 128-bit output (Aumasson & Bernstein 2012) of each point; of each element over the 64-bit point
/// hashes and its entity, for edges, triangles and tets in ascending order with the orientation, for others in the
/// smallest order that a rotation gives; these are added up modulo 2^128 per kind, which makes a hash of the multiset
/// (Bellare & Micciancio 1997), and hashed once more together with the counts.
///
/// Pre: indices in range, arrays of matching lengths; throws Error(InvalidArgument) otherwise. Linear; 8 bytes per
/// point of working memory. `loop` carries out the work; the digest does not depend on it. Thread safety: pure.
std::string mesh_digest(const Mesh& mesh, const BlockLoop& loop = serial_loop());

/// The same for the fields of `mesh`: 32 digits over the name, the number of components and the values (bit for bit,
/// but -0 equals +0) of each, every tuple together with the hash of the point or cell that it hangs on.
///
/// Laws: unchanged when points, cells or fields are renumbered together with what hangs on them; changed by any change
/// of a value, a name, or of a carrier that has a value. Says nothing of a mesh without fields.
/// Pre, complexity and thread safety as for `mesh_digest`, times the number of fields.
std::string field_digest(const Mesh& mesh, const BlockLoop& loop = serial_loop());

}  // namespace tetloom
