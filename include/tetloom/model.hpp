#pragma once
// Geometric models: their topology and shape, and how they are read from files or made of triangles.
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/host.hpp"
#include "tetloom/ids.hpp"
#include "tetloom/vec.hpp"

// The functional interface to a geometric model (Beall, Walsh & Shephard 2004): topology as plain tables, shape through
// small objects that answer geometric questions. OpenCASCADE and discrete (facet) models implement it; no algorithm
// knows which one it has.
//
// Units: model length for points and distances, radians for angles; (u,v) and t are in the units of the
// parametrisation. Frame: the model's own, right-handed.
//
// Thread safety: a GeometricModel is immutable and may be shared by any number of threads. EdgeGeometry and
// FaceGeometry objects hold evaluation caches: each task makes its own and shares it with nobody.

namespace tetloom {

/// RGB.
struct Color {
  float red = 0, green = 0, blue = 0;  ///< linear, 0 … 1
  friend constexpr bool operator==(const Color&, const Color&) = default;
};

/// What a CAD file says of an entity beside its shape.
struct EntityAttributes {
  std::string name;
  std::optional<Color> color;
  std::string layer;
  double tolerance = 0;  ///< how far neighbouring geometry may lie from this entity's own (model length)
  std::string group;     ///< a name for several entities of one dimension in files for solvers; empty: each its own
};

/// One appearance of an edge in a loop of a face. A seam appears twice in the same face, once on each side of the
/// parameter domain.
struct EdgeUse {
  ModelEdgeId edge;
  bool forward = true;       ///< the loop runs along the edge's own direction
  bool second_side = false;  ///< of a seam's two parameter curves, the second one
};

/// A closed chain of edge uses with the face on its left, seen from the tip of the face's normal.
using ModelLoop = std::vector<EdgeUse>;

/// The regions on the two sides of a face; an invalid id stands for the outside.
struct FaceSides {
  ModelRegionId front;  ///< the region into which the face's normal points
  ModelRegionId back;   ///< the region out of which it points
};

/// The ends of a model edge.
struct ModelEdgeTopology {
  std::array<ModelVertexId, 2> vertices;  ///< at the start and the end of the edge's range; equal when closed
  bool degenerate = false;                ///< a point in space, such as the pole of a sphere
};

/// Who bounds whom, indexed by the ids of the entities.
struct ModelTopology {
  std::size_t vertex_count = 0;
  std::vector<ModelEdgeTopology> edges;
  std::vector<std::vector<ModelLoop>> face_to_loops;
  std::vector<FaceSides> face_to_sides;
  std::vector<std::vector<ModelFaceId>> region_to_faces;  ///< each face once, ascending
  std::size_t face_count() const { return face_to_loops.size(); }
  std::size_t edge_count() const { return edges.size(); }
  std::size_t region_count() const { return region_to_faces.size(); }
  std::size_t count(int dim) const;
};

/// A closed interval of a curve parameter.
struct ParameterRange {
  double lo = 0, hi = 0;
};

/// A point of a curve, and its parameter.
struct CurvePoint {
  double t = 0;
  Vec3 point;
  double distance = 0;  ///< from the point asked for
};

/// Where a face stands whose shape a model has in several places, as an assembly has its screws.
struct FacePlace {
  std::uint32_t shape = kNone;  ///< the first face of that shape, with the same (u,v), loops and edges; none: not known
  RigidMotion motion;           ///< from the frame of the shape
};

/// Questions about one edge. Not for degenerate edges.
class EdgeGeometry {
 public:
  virtual ~EdgeGeometry() = default;
  virtual ParameterRange range() = 0;
  /// The period of t, or 0.
  virtual double period() = 0;
  virtual Vec3 evaluate(double t) = 0;
  /// dX/dt.
  virtual Vec3 derivative(double t) = 0;
  /// 1 / radius of the osculating circle; 0 where straight or undefined.
  virtual double curvature(double t) = 0;
  virtual CurvePoint closest_point(const Vec3& x) = 0;
};

/// How the (u,v) of a face behave.
enum class Parametrization {
  Smooth,    ///< continuous, with derivatives; loops have parameter curves
  Piecewise  ///< per facet (u = facet index + barycentric, v = barycentric): evaluate and closest_point are inverse to
             ///< each other, but nearby points may have unrelated (u,v)
};

/// The parameters of a face lie in it.
struct ParameterBox {
  Vec2 lo, hi;
};

/// A point of a surface, and the first derivatives there.
struct SurfaceDerivatives {
  Vec3 point, du, dv;
};

/// At a point of a surface.
struct PrincipalCurvatures {
  double largest = 0, smallest = 0;  ///< by absolute value; signs relative to the normal
};

/// A point of a surface, and its parameters.
struct SurfacePoint {
  Vec2 uv;
  Vec3 point;
  double distance = 0;  ///< from the point asked for
};

/// A facetted face. Points on the boundary know which model edge or vertex they lie on.
struct Tessellation {
  std::vector<Vec3> points;
  std::vector<Vec2> uv;                                   ///< one per point
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;  ///< counter-clockwise seen from the tip of the normal
  std::vector<ModelEntity> classification;                ///< one per point: vertex, edge or this face
  std::vector<double> edge_parameter;                     ///< one per point: t, for points classified on an edge
};

/// Questions about one face.
class FaceGeometry {
 public:
  virtual ~FaceGeometry() = default;
  virtual Parametrization parametrization() = 0;
  /// Contains all loops of the face.
  virtual ParameterBox parameter_box() = 0;
  /// The periods of u and v, 0 where not periodic.
  virtual Vec2 period() = 0;
  virtual Vec3 evaluate(const Vec2& uv) = 0;
  virtual SurfaceDerivatives derivatives(const Vec2& uv) = 0;
  /// Unit normal, du × dv where that is defined, else its limit; zero where there is none.
  virtual Vec3 normal(const Vec2& uv) = 0;
  virtual PrincipalCurvatures curvature(const Vec2& uv) = 0;
  /// The point of the face's surface nearest to `x`; `guess` speeds the search up and picks the branch.
  virtual SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>& guess) = 0;
  /// (u,v) of the point `t` of an edge in this face's boundary. Not for Piecewise faces.
  /// For a degenerate edge, t runs over the `edge_range`.
  virtual Vec2 edge_parameters(const EdgeUse& use, double t) = 0;
  /// The range of t for `edge_parameters`; it also serves degenerate edges.
  virtual ParameterRange edge_range(const EdgeUse& use) = 0;
  /// Facets that deviate from the face by at most `chord` (model length) and turn by at most `angle` (radians).
  virtual Tessellation tessellate(double chord, double angle) = 0;
};

/// What a process holds of a model of which it reads the shapes of edges and faces when it needs them.
struct ShapeMemory {
  std::uint64_t most_held_bytes = 0;  ///< at once, so far
  std::uint64_t total_bytes = 0;      ///< of all edges and faces
};

/// A geometric model. Entities are numbered from 0 in each dimension; the numbering depends on the file alone.
class GeometricModel {
 public:
  virtual ~GeometricModel() = default;

  const ModelTopology& topology() const { return topology_; }
  const EntityAttributes& attributes(ModelEntity entity) const;
  NamedEntity named(ModelEntity entity) const;
  /// Contains the model, not much larger than needed.
  const Box3& bounding_box() const { return bounding_box_; }
  /// Metres per model length unit; 0 where the file does not say.
  double metres_per_unit() const { return metres_per_unit_; }

  virtual Vec3 vertex_point(ModelVertexId id) const = 0;
  virtual std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const = 0;
  virtual std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const = 0;
  virtual double area(ModelFaceId id) const = 0;
  /// None unless the model knows its shapes apart from their places.
  virtual FacePlace place(ModelFaceId) const { return {}; }
  /// Signed as the region's boundary is oriented; positive for a proper solid.
  virtual double volume(ModelRegionId id) const = 0;
  /// None where the model has all of its shapes at hand.
  virtual std::optional<ShapeMemory> shape_memory() const { return {}; }
  /// The share of an edge or a face in ShapeMemory::total_bytes; 0 of other entities, and where all are at hand.
  virtual std::uint64_t shape_bytes(ModelEntity) const { return 0; }

 protected:
  ModelTopology topology_;
  std::array<std::vector<EntityAttributes>, 4> attributes_;
  Box3 bounding_box_;
  double metres_per_unit_ = 0;
};

// Reading a geometric model from a file: STEP, IGES and BREP through OpenCASCADE, STL and OBJ as discrete models.

/// How a model file is read.
struct ReadOptions {
  bool heal = true;      ///< repair what OpenCASCADE can repair (wires, small edges, tolerances, orientation)
  bool imprint = false;  ///< fuse touching solids so that they share faces (General Fuse)
  double feature_angle = 0.6981317007977318;  ///< radians; discrete models are cut into faces where facets turn by more
  double fill_holes = 0;                      ///< model length; of discrete models, holes at most as wide are closed
  /// Solids that are made anew in the end, as rebuild_solids does, those of one list after those of the other: regions
  /// of the model as it is before. So a mesh of such a model meets the same model again.
  std::vector<std::vector<ModelRegionId>> rebuilt;
};

/// One thing that was repaired, with how often.
struct HealingStep {
  std::string what;
  std::size_t count = 0;
};

/// A model, and what was done to it and noticed when it was read.
struct ModelDocument {
  std::unique_ptr<GeometricModel> model;
  std::vector<HealingStep> healing;
  std::vector<Diagnostic> warnings;  ///< invalid shapes that remain, open shells, entities left out …
  std::string format;                ///< "STEP", "IGES", "BREP", "STL" or "OBJ"
};

/// Reads the model in `path`; the format follows from the file's extension (.step .stp .iges .igs .brep .stl .obj,
/// any case) and must agree with its content.
/// Errors: InvalidArgument (unknown extension, options out of range), InputUnreadable, InputUnsuitable (no shape,
/// solids that cannot be made anew), Cancelled, OutOfMemory. Thread safety: may be called from any thread; calls are
/// serialised inside. Checks and measurements run on the threads of `loop`; the model does not depend on it.
ModelDocument read_model(const std::filesystem::path& path, const ReadOptions& options = {},
                         const CancelToken* cancel = nullptr, const BlockLoop& loop = serial_loop());

/// A document with some of its solids made anew from the space that their boundary encloses: for those whose boundary
/// crosses itself. Names and colours follow the faces; all else is as it was, but for the numbering. Facets are cut
/// where they cross, and those inside left out; what the surface winds around at least once is inside. Solids of facets
/// that have others on the other side of a face stay as they are. None where no solid can be made anew. `solids` are
/// regions of the document's model. Errors and thread safety: as read_model.
std::optional<ModelDocument> rebuild_solids(const ModelDocument& document, const std::vector<ModelRegionId>& solids,
                                            const CancelToken* cancel = nullptr, const BlockLoop& loop = serial_loop());

// Models for several processes: one reads the file and stores the shapes, each then reads those that it needs.

/// Writes a document to a file from which open_stored_model makes it anew, for processes of this program on machines of
/// one kind. False, and no file left, for models that read_model did not make. Errors: OutputFailed, and those of
/// questions to the model. Thread safety: as these; on the threads of `loop`.
bool store_model(const ModelDocument& document, const std::filesystem::path& path,
                 const BlockLoop& loop = serial_loop());

/// The document that store_model wrote. Its model answers as the one that was stored, to the last bit; it holds the
/// shapes of edges and faces that were asked for last, `most_shape_bytes` at most or a single one, and reads others
/// from the file, which may be removed from its folder once it is open. Its solids cannot be made anew
/// (rebuild_solids). Errors: InputUnreadable.
ModelDocument open_stored_model(const std::filesystem::path& path, std::uint64_t most_shape_bytes);

// Geometric models made of facets: STL and OBJ files, or triangles in memory.
//
// The facets are cleaned (equal points merged, degenerate and duplicate facets removed, cracks and T-junctions closed,
// needles collapsed, holes filled where that is asked for), oriented, and cut into faces and edges by feature angle, by
// group and where facets do not meet in pairs. Surfaces that enclose space bound regions: a shell within a region is a
// void, a shell within a void is a region again. Open surfaces are sheets; a sheet within a region has that region on
// both sides. A face with one region has its normal pointing out of it; sheets keep the orientation that most of their
// facets have.
//
// What differs from other models:
// - A face that is closed and smooth (a sphere) has no loops at all. A cylinder's side has two loops and no seam.
// - A crease that fades out within a face is an edge that the face has twice, once in each direction. Creases of a few
//   facet edges are not kept, nor faces of a few facets under 0.3 % of the box's diagonal, which noise makes, nor is an
//   isolated peak such as the tip of a cone.
// - Surfaces that touch in a single point do not know of each other there.
// - An edge where a one-sided surface (Möbius strip) is cut open appears twice in its face, both times in the same
//   direction.
//
// Faces are Parametrization::Piecewise. With p0, p1, p2 the corners of the face's facet number f, and points written
// as (1 - b1 - b2)·p0 + b1·p1 + b2·p2 with barycentric coordinates in 0 … 1,
//     u = 2·f + b1,   v = b2,
// so that b1 = 1 does not run into the next facet: u in (2f + 1, 2f + 2) does not occur. evaluate(closest_point(x).uv)
// is closest_point(x).point exactly. A guess picks the side of a thin wall or of a crease: facets that face away from
// the guess's normal are then left out. Normals and curvatures are interpolated between the points of the face, where
// they come from quadrics fitted to the points around, of this face alone (Cazals & Pouget 2003); where the normal
// strays far from the facet's own, the latter is taken. tessellate() gives the facets themselves, whatever is asked
// for. Edges are polylines over their arc length.
//
// Thread safety: as GeometricModel; the objects for edges and faces keep what they need of the model alive.

/// Reads an STL file (ASCII or binary, told apart by content) or an OBJ file; the format follows from the extension,
/// any case. Groups and objects of an OBJ file, and solids of an ASCII STL file, bound faces and name them; where there
/// is only one of them it names the regions.
/// Errors: InvalidArgument (other extension, feature angle not in (0, π]), InputUnreadable (missing, a directory,
/// empty, truncated, another format), InputUnsuitable (no facets, coordinates that are not finite, facets that overlap
/// at an edge of three or more), Cancelled, OutOfMemory. Thread safety: may be called from any thread, several calls at
/// once.
ModelDocument read_discrete_model(const std::filesystem::path& path, const ReadOptions& options = {},
                                  const CancelToken* cancel = nullptr);

/// Makes a model of triangles in memory, which are treated as those of a file. `feature_angle` in radians; triangles of
/// different groups lie in different faces. Pre: `tri_to_group` is empty or as long as `triangles`.
/// Errors: InvalidArgument (arrays that do not fit together, indices out of range), InputUnsuitable as above.
std::unique_ptr<GeometricModel> make_discrete_model(std::span<const Vec3> points,
                                                    std::span<const std::array<std::uint32_t, 3>> triangles,
                                                    double feature_angle,
                                                    std::span<const std::uint32_t> tri_to_group = {});

// The space around a model.

/// The space between a model and a box around it, as a model: for flows around it. The box has the centre of the
/// model's bounding box and `factor` times its sides, where those of a flat model count as a tenth of the longest. Its
/// one region is named "far_field", and so are the faces of the box, "far_field_1" to "far_field_6" (-x, +x, -y, +y,
/// -z, +z), which come last. Before them come the faces of the given model that the space around it touches, with their
/// names, in their order, with the region on the sides that were outside; what is inside of solids, voids in them among
/// it, is left out. Sheets have the region on both sides. The volume of the region is the box less the volumes of the
/// solids and of voids in them, which are taken from facets. Shares ownership of `model`.
/// Errors: InvalidArgument for no model and unless 1 < factor < infinity; InputUnsuitable for a model without faces.
/// Solids that touch without common faces touch in the result as well.
std::unique_ptr<GeometricModel> put_into_box(std::shared_ptr<const GeometricModel> model, double factor);

}  // namespace tetloom
