#pragma once
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
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "core/cad/read_model.hpp"

namespace tetloom {

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

}  // namespace tetloom
