#pragma once
// What a surface has to stay true to while it is changed.
#include <cstdint>
#include <functional>
#include <span>

#include "core/geometry/model_projector.hpp"
#include "mesher/tets/surface_triangles.hpp"
#include "tetloom/ids.hpp"

namespace tetloom::tets {

/// What a change of the surface must keep to, where it did before: the cosine between triangles and the model (30
/// degrees), and how far the middle of a model edge's piece, or of a diagonal, lies from the model, in lengths of it
/// (18 degrees of a circle).
inline constexpr double kLeastCosine = 0.87, kLargestSag = 0.04;
/// How far the end of a step may lie from the model, in lengths of the step.
inline constexpr double kFarthest = 0.5;

/// Triangles as they would become.
struct SurfaceChange {
  std::span<const Vec3> points;              ///< of the whole surface
  std::span<const std::uint32_t> triangles;  ///< that change
  std::span<const TriangleVerts> verts;      ///< of those, afterwards
};

/// A surface that may change. Its points are the first ones of the mesh.
struct ChangeableSurface {
  std::span<TriangleVerts> tri_to_vert;          ///< changed in place
  std::span<const std::uint32_t> tri_to_face;    ///< model face of each triangle
  std::span<const ModelEntity> point_to_entity;  ///< the model face or edge inside of which a point lies and may slide;
                                                 ///< those on anything else stay; empty: all stay
  /// Whether an edge is a piece of a model edge: it stays an edge. Empty: none is.
  std::function<bool(std::uint32_t, std::uint32_t)> is_kept{};
  SurfaceProjector project{};  ///< empty: only what lies in a plane is changed
  /// Whether the triangles would meet no others where no tets are to tell; when they do not, the change is made. Empty:
  /// they never do.
  std::function<bool(const SurfaceChange&)> is_clear{};
};

}  // namespace tetloom::tets
