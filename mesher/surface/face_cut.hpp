#pragma once
// Cuts a large face into pieces along chains of points in its plane, so that the pieces can be meshed at once.
//
// The face is first meshed coarsely; the coarse triangles are shared out to pieces, and the edges between pieces
// divided at the spacing that the sizes ask for. What comes out depends on the face, its rim and the size field, never
// on threads.
#include <optional>

#include "mesher/surface/rim_patch.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// Triangles per piece; a face with fewer than one and a half of it is not cut.
inline constexpr double kTrianglesPerPiece = 15000;

/// What lies at a vertex of a cut: `zone` numbers pairs of pieces, `junction` the places where three pieces or more
/// meet or where a cut ends on the rim. At most one of the two is set.
struct CutVertex {
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::uint32_t zone = kNone, junction = kNone;
};

/// One piece of a face that was cut.
struct FacePiece {
  std::vector<std::uint32_t> vertices;                 ///< of FaceCut::vertices
  std::vector<std::array<std::uint32_t, 2>> segments;  ///< of `vertices` here; one inside of the piece is there twice
};

/// The rim of a face and the chains that cut it.
struct FaceCut {
  Vec2 scale{1, 1};
  bool has_poles = false;
  std::vector<PatchVertex> vertices;  ///< those of the rim first; those of cuts have no node
  std::vector<CutVertex> kinds;       ///< one per vertex
  std::vector<FacePiece> pieces;
  std::vector<std::array<std::uint32_t, 2>> zones;    ///< the two pieces, smaller first
  std::vector<std::vector<std::uint32_t>> junctions;  ///< the pieces that meet, ascending
  std::vector<std::uint32_t> junction_to_vertex;
};

/// The number of triangles that the sizes call for on a face in its plane.
double estimate_triangles(const RimPatch& face, const PatchSurface& surface);

/// Cuts a large face; none where it has too few triangles, no smooth parametrisation, or a rim without a valid
/// triangulation (meshing it whole says why). May be called for several faces at once. Errors: those of the face's
/// geometry, Cancelled.
std::optional<FaceCut> cut_large_face(const GeometricModel& model, ModelFaceId face,
                                      const FaceSurroundings& surroundings, const TaskRunner& runner);

}  // namespace tetloom
