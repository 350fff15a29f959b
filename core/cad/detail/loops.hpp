#pragma once
// Chaining the edges of a face's wire into closed loops. Private to core/cad.
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom::cad {

/// One traversal of an edge along a face's boundary, with the face on its left.
struct LoopPiece {
  EdgeUse use;
  ModelVertexId start, end;
  Vec2 uv_start, uv_end;            ///< scaled so that the face's parameter box is about the unit square
  Vec2 tangent_start, tangent_end;  ///< in the same scale, along the traversal; any length
};

/// Pieces of edges in closed loops.
struct ChainedLoops {
  std::vector<ModelLoop> loops;
  std::vector<LoopPiece> open;  ///< pieces that close no loop
};

/// Chains pieces end to start. Where several pieces leave a vertex, the one nearest in (u,v) follows, and among those
/// equally near the sharpest turn to the left: so each loop keeps the face's interior on its left, a wire that touches
/// itself in a vertex falls into simple loops, and an edge that sticks into the face is run up and down.
/// Every piece ends up in exactly one loop or in `open`. Depends on the order of `pieces` alone.
ChainedLoops chain_loops(const std::vector<LoopPiece>& pieces);

}  // namespace tetloom::cad
