#pragma once
// CAD files with the faults that real ones have, made on the spot with OpenCASCADE. Lengths in millimetres.
#include <filesystem>

namespace tetloom::test {

enum class Fault {
  TouchingLoops,       ///< a square of 10 and a triangular hole whose corner touches a side's vertex, and whose
                       ///< parameter curves end 5e-5 beyond it
  TangentHole,         ///< a square of 20 and a hole of radius 3 that a side cuts by 1e-4: line and arc coincide there
  TangentHoleInPlate,  ///< the same 5 thick
  DoubledEdge,   ///< two squares of 10 side by side, one face each, that end in two lines between the same vertices
  FoldedCorner,  ///< an arrowhead pushed by 5, with a bilinear top that folds over at the concave corner
  CurveShortOfVertex,  ///< a box of 10 with an edge whose line runs the wrong way: its vertices have a tolerance of 20
  CrossingShells,  ///< the loose faces of a box of edge 10 and of a cylinder that leaves it, though its vertices are
                   ///< inside
  NestedShells,    ///< the loose faces of two boxes of edge 10 and 4, one inside the other
  CollapsedFaces,  ///< the loose faces of a box, one without area on each of two sides, and one that is a point
  FloorBeyondOuterFace,    ///< a box of 10 with a hole of radius 2 that is 12 deep, its floor outside; and another box
  FloorsBeyondOuterFaces,  ///< six such boxes with holes, in a row, and the other box
  FloorInOuterFace,        ///< a box of 10 with a hole of radius 2 whose floor lies in the opposite face
  FloorWithoutThickness,   ///< the same with a floor 1e-11 thick
  FlatSolid,               ///< of two faces that lie on each other
  FlatSolidAndBox,         ///< the same beside a box of 10
  OverlappingBoxes,        ///< two boxes of edge 10, one shifted by (5, 5, 5)
  NarrowStep,  ///< a cylinder of radius 10 and height 20 with a flat 1 deep in its upper half: the step below
               ///< lies between an arc and its chord
  ThinRod      ///< radius 0.1, length 10
};

/// Writes a BREP file. Throws std::runtime_error when it fails.
void write_faulty(Fault fault, const std::filesystem::path& path);

}  // namespace tetloom::test
