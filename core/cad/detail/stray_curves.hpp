#pragma once
// Edges whose curve misses their vertices. Private to core/cad.
#include <cstddef>
#include <TopoDS_Shape.hxx>

namespace tetloom::cad {

/// Lets the curves of edges run between their vertices where they end far from them, by more than a twentieth of the
/// edge: a straight edge becomes the line between its vertices, another one is cut out of its curve anew where that
/// passes by the vertices, in whichever direction. Parameter curves follow, and vertices get the tolerance that is
/// left. Changes edges in place. Returns how many were changed.
std::size_t repair_stray_curves(const TopoDS_Shape& root);

}  // namespace tetloom::cad
