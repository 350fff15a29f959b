#pragma once
// Axes, places and directions of curves and surfaces, bit by bit: OpenCASCADE makes directions unit vectors again when
// it reads them, so that points move by 1e-17. Private to core/cad.
#include <TopoDS_Shape.hxx>
#include <vector>

namespace tetloom::cad {

/// The coordinates of all frames in the curves and surfaces of a shape, in the order in which they lie in it.
std::vector<double> frames_of(const TopoDS_Shape& shape);

/// Sets those of a shape that was read from what frames_of had of the one that was written. Changes its curves and
/// surfaces. False where they are not of the same kinds; the shape is of no use then.
bool set_frames(const TopoDS_Shape& shape, const std::vector<double>& frames);

}  // namespace tetloom::cad
