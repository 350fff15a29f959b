#pragma once
// What one part holds while its tets are made, and what all parts may read.
#include <array>
#include <cstdint>
#include <vector>

#include "core/tets/find_triangles.hpp"
#include "mesher/lattice/lattice_cells.hpp"
#include "mesher/lattice/lattice_core.hpp"
#include "mesher/parts/decomposition.hpp"
#include "mesher/parts/part_surface.hpp"
#include "mesher/tets/optimizer.hpp"
#include "mesher/volume/complex_filling.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// The same name of a vertex in all parts: points of the surface by their number in the complex, all others by the part
/// that made them and a number there.
using VertKey = std::uint64_t;

constexpr VertKey key_of(PartId maker, std::uint32_t index) { return (VertKey{maker.value} + 1) << 32 | index; }
constexpr bool is_of_surface(VertKey key) { return key >> 32 == 0; }
constexpr PartId maker_of(VertKey key) { return PartId((key >> 32) - 1); }

/// The circumscribed ball of a tet, which has to be empty of points that other parts know.
struct OpenBall {
  std::array<Vec3, 4> corners;  ///< positive
  Vec3 center;
  double radius = 0;  ///< infinite where it has no finite number
};

/// A triangle of the surface that the optimiser has given other vertices.
struct ChangedTriangle {
  std::uint32_t triangle = 0;  ///< of the complex; its face and its sides are as before
  std::array<std::uint32_t, 3> verts{};
};

/// The vertices of a tet, ascending.
using TetKeys = std::array<VertKey, 4>;

inline constexpr std::size_t kStripRounds = std::tuple_size_v<decltype(FillingPartsFigures::strips)>;

/// What a part makes its core and the shell around it of, until they are joined. Vertices of both: points of the
/// surface first, then sites level by level, then what others have told.
struct PartShell {
  std::vector<std::uint32_t> surface;    ///< points of the complex that the part knows, ascending
  std::vector<std::uint32_t> triangles;  ///< triangles of the complex between these

  std::vector<lattice::LevelPoints> levels;  ///< own sites, then those of other parts
  std::vector<std::uint32_t> own_first;      ///< per level: the number of its first own site; and one past the last
  tets::TetMesh core_mesh;                   ///< its points go over to `mesh`
  lattice::LatticeCore core;

  GrowingArray<VertKey> keys;                  ///< of all vertices
  std::vector<std::uint16_t> pure_around;      ///< per vertex: see LatticeCore; foreign ones: any
  std::vector<tets::TriangleVerts> tri_verts;  ///< vertices of `triangles`
  std::vector<std::uint32_t> verts;            ///< of the shell: own and foreign
  tets::TetMesh mesh;
  std::size_t size = 0;                ///< how many of `verts` are in it
  std::uint32_t first_outer = 0;       ///< see DelaunayResult
  std::vector<std::uint32_t> kept;     ///< own tets, ascending
  std::vector<OpenBall> open_balls;    ///< of tets that reach beyond what the part knows
  std::vector<TetKeys> asked_tets;     ///< whose balls have ever been open, ascending
  std::vector<std::uint32_t> missing;  ///< own triangles of the complex that the shell does not have

  std::uint32_t surface_count() const { return static_cast<std::uint32_t>(surface.size()); }
};

/// Tets of which all parts know the vertices by their keys: those of a part, or a strip of them on its way.
struct KeyedTets {
  tets::TetMesh mesh;
  GrowingArray<VertKey> keys;        ///< per point; ascending for those that came with the tets of a strip
  GrowingArray<std::uint8_t> waits;  ///< per point: 1 where it could not move or lose edges, being between parts
  GrowingArray<float> qualities;     ///< cubed, per tet, once optimised; of dead ones as in a WorkingMesh
  std::uint32_t surface_count = 0;   ///< points of the surface that stand first
};

/// The tets of a part, once core and shell are joined.
struct PartTets : KeyedTets {
  std::vector<std::uint32_t> triangles;  ///< of the complex, that the part has known from the beginning, ascending
  std::uint32_t next_index = 0;          ///< of the next point made here
  bool has_dead = false;                 ///< tets, once optimised
};

/// A vertex on the border of a part.
struct BorderVert {
  std::uint32_t vert;
  tets::FaceCode face;  ///< the first open one that has it
};

/// A vertex that other parts are told of.
struct ToldVert {
  std::uint32_t vert;
  double reach;  ///< parts farther away are not told of it
};

/// What open faces tell of a part's border.
struct PartBorder {
  std::vector<BorderVert> verts;  ///< of open faces
  std::vector<ToldVert> told;     ///< those of `poor` and `astray`, ascending
  std::vector<VertKey> poor;      ///< of `verts`, those that wait and have poor tets, ascending
  std::vector<VertKey> astray;    ///< of `verts`, those far outside of the part's box, ascending
};

/// A vertex at which some part's tets are poor.
struct SharedVert {
  VertKey key;
  std::uint32_t vert;
  bool is_poor;  ///< waits, and tets at it are poor
};

/// What a part knows of its border with others from one round of strips to the next.
struct StripState {
  bool knows_waits = false;                ///< whether `waits` of the part says all it has to
  std::vector<tets::FaceCode> open_faces;  ///< with nothing of the part, and no surface, behind them
  bool open_faces_changed = true;          ///< since `border` was found
  PartBorder border;                       ///< of these open faces
  std::vector<SharedVert> shared;          ///< ascending
  Bytes own_piece;                         ///< of a strip that this part takes
  std::vector<tets::FaceCode> opened;      ///< faces that taking tets out has opened
};

/// What a part and its neighbours tell each other in the end.
struct BorderCheck {
  std::vector<std::uint64_t> open_names;         ///< of the part's open faces
  std::vector<std::uint64_t> unmet_names;        ///< of those, that no neighbour has told of
  std::vector<std::uint32_t> surface_elsewhere;  ///< points of the complex that other parts' tets have
  double least_angle = 0;                        ///< radians: of this part's tets and of what neighbours tell of theirs
};

/// Everything that one part has, stage by stage.
struct PartState {
  PartShell shell;
  PartTets tets;
  StripState strips;
  BorderCheck check;
  std::vector<ChangedTriangle> changed_triangles;
  std::size_t seen_sides = 0;  ///< of surface triangles, by tets of this part
  FillingFigures figures;
  tets::Fault fault;
};

/// Read by all parts, changed by none.
struct SharedInput {
  const volume::FillingInput& filling;
  const lattice::LatticeCells& cells;
  const Decomposition& decomposition;
  const PartSurface& surface;
  const tets::TrianglesByVertex& triangles;  ///< of the complex
  Box3 box;                                  ///< of the surface
  std::uint32_t only_region = 0;             ///< kNone: there are several

  bool is_graded() const { return cells.level_count() > 1; }
  /// The size that a lattice or the field has at a place that the surface is at.
  double size_at(const Vec3& x) const { return filling.sizes.size_at(x); }
};

/// How far a part knows the points of the shell beyond its box, in sizes of these points.
inline constexpr double kShellReach = 2;

}  // namespace tetloom::parts
