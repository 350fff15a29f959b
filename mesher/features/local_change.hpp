#pragma once
// Local modifications of a triangulated surface, planned before they are made: a vertex is merged into another, or a
// triangle goes because its apex is put onto the opposite edge (Dey, Shephard & Georges 1997). Both keep the surface's
// topology, and neither looks at shapes.
#include <cstdint>
#include <optional>
#include <vector>

#include "mesher/features/surface_complex.hpp"

namespace tetloom::features {

/// A triangle that takes the place of a removed one.
struct AddedTriangle {
  Triangle verts;
  std::uint32_t source = 0;  ///< the removed triangle whose place it takes
};

/// Triangles that go and those that come instead, with what follows for pieces of model edges.
struct LocalChange {
  std::vector<std::uint32_t> removed;
  std::vector<AddedTriangle> added;
  std::uint32_t gone = kNone;  ///< the vertex that is merged into `kept`; kNone: none is
  std::uint32_t kept = kNone;  ///< the vertex that stays, or the apex
  Piece split{kNone, kNone};   ///< the edge onto which the apex is put
  Vec3 place;                  ///< of `kept` afterwards
  ModelEntity entity;          ///< of `kept` afterwards
};

/// Merges `gone` into its neighbour `kept`, which stays where it is.
///
///        x                x
///       /|\               |
///   gone-+-kept   ->     kept          (the triangles at the edge vanish, those at `gone` move to `kept`)
///       \|/               |
///        y                y
///
/// None where the topology of the surface would change (the link condition of Dey, Edelsbrunner, Guha & Nekhayev 1999,
/// with edges of any number of triangles), or where `kept` lies on a model entity of higher dimension than `gone`, or
/// on another one of the same face dimension.
std::optional<LocalChange> plan_collapse(const SurfaceComplex& surface, std::uint32_t gone, std::uint32_t kept);

/// Puts the apex of a triangle, its corner `i`, onto the opposite edge u v, which is split there; the triangle
/// vanishes.
///
///         p                      p
///       /   \                  / | \                (p is drawn above u v; afterwards it lies between them)
///      u-----v       ->       u  |  v
///       \   /                  \ | /
///         w                      w
///
/// Inside of a face this is the swap of u v for p w. An apex inside of a face moves onto a piece of a model edge, and
/// belongs to that edge then; other apices stay where they are, and the edge bends. None where the topology would
/// change.
std::optional<LocalChange> plan_snap(const SurfaceComplex& surface, std::uint32_t triangle, int i);

/// Makes the change.
void apply(const LocalChange& change, SurfaceComplex& surface);

}  // namespace tetloom::features
