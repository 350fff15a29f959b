#pragma once
// Makes the triangles of a patch as equilateral and as large as asked, by flips, vertex moves, splits and collapses.
//
// Vertices move by a damped Newton step on Σ 1/q² over their ball, q = 4√3·A/Σl², which is convex while the ball stays
// valid; edges flip when that raises the smaller quality of their two triangles; edges longer than √2 or shorter than
// 1/√2 of the size are split and collapsed (Botsch & Kobbelt 2004; departures: qualities instead of valences, Newton
// instead of averaging). No operation makes an invalid triangle, touches a fixed edge or moves a rim vertex.
#include <functional>

#include "mesher/surface/patch.hpp"

namespace tetloom {

/// How much a patch is changed.
struct PatchOptimizerOptions {
  int rounds = 3;
  /// Split and collapse until the sizes fit, from whatever density: for patches that start from a tessellation.
  bool adapt_density = false;
};

void optimize_patch(Patch& patch, const PatchSurface& surface, const PatchOptimizerOptions& options,
                    const std::function<bool()>& keep_going);

}  // namespace tetloom
