#pragma once
// Vertices at which the tets do not hang together through faces, as where two bodies touch in an edge or a vertex
// alone.
//
//    \ umbrella /
//     \        /
//      \      /
//  ------- v ------  outside
//      /      \          .
//     /        \         .
//    / umbrella \        .
//
// Operations see the tets that they reach through faces. So each *umbrella* of tets has a vertex of its own while a
// mesh is adapted, and these are one again in the end; all of them stay where they are, and so do the edges at which
// umbrellas touch.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "adapt/parts/whole_mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// What vertices at which umbrellas touch lie on; they are corners meanwhile, with numbers from `first` on.
struct TouchingVerts {
  std::uint32_t first = 0;
  std::vector<PackedEntity> to_entity;
  std::vector<Number> verts;  ///< those that were there before, ascending; new ones come behind all of these
};

/// Gives each umbrella a vertex of its own, those behind the first one new ones, and marks the edges at which umbrellas
/// touch
/// (`kTouching`). Vertices at which the surface meets itself without several umbrellas are corners as well.
/// Complexity: linear in the tets, and sorting for the surface.
TouchingVerts separate_umbrellas(WholeMesh& whole, const TaskRunner& runner);
/// The same of what a slice has become: with names and numbers as of the whole mesh, those of new vertices added to the
/// slice's. What is returned is that of the whole mesh. In SharedWork::together.
TouchingVerts separate_umbrellas(WholeMesh& whole, MeshSlice& slice, const SharedWork& work);

/// The vertices of the tets of a mesh of `given` points as they were before `separate_umbrellas`.
std::vector<std::array<std::uint32_t, 4>> tets_before_umbrellas(const WholeMesh& whole, const TouchingVerts& touching,
                                                                std::size_t given, const TaskRunner& runner);

/// Makes one vertex of those that `separate_umbrellas` made of one. Returns, of each vertex that is left, the number
/// that it had, ascending; empty where all are left. Neighbours, hints and states are of no use then.
std::vector<std::uint32_t> join_umbrellas(WholeMesh& whole, const TouchingVerts& touching);

}  // namespace tetloom::adapt
