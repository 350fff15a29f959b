#pragma once
// CAD files for tests, made on the spot with OpenCASCADE. Lengths in millimetres.
#include <filesystem>

namespace tetloom::test {

enum class Sample {
  Box,                 ///< 10 × 20 × 30 from the origin
  Cylinder,            ///< radius 5, height 10, axis z
  Sphere,              ///< radius 5
  HalvedSphere,        ///< the sphere, of a face above z = 0 and one below
  Torus,               ///< radii 10 and 3
  Cone,                ///< radius 5, height 10, with its apex
  TurnedSpline,        ///< a B-spline profile turned about z (surface of revolution)
  PushedSpline,        ///< a closed B-spline outline pushed along z (surface of extrusion)
  SplineSolid,         ///< the cylinder with all surfaces and curves as rational B-splines
  LoftedSolid,         ///< a B-spline loft through three outlines
  OffsetSheet,         ///< one face on the offset of a B-spline surface
  BezierSheet,         ///< one face on a Bézier surface
  DrilledBox,          ///< the box with a hole of radius 3 along z through (5, 10)
  HollowBox,           ///< the box with a closed spherical cavity of radius 3
  TouchingBoxes,       ///< two boxes of edge 10 that touch in a part of a face, not sharing it
  SharingBoxes,        ///< two boxes of edge 10 that share a face
  InsideOutBox,        ///< the box with all faces turned
  PlacedInsideOutBox,  ///< that box as a part moved by 100 along x
  OpenBox,             ///< a solid of the box's faces but one
  LooseFaces,          ///< the six faces of the box, sharing nothing
  LooseHollow,         ///< the faces of HollowBox, sharing nothing
  Sheet,               ///< one plane face of 10 × 20
  SheetWithSpur,       ///< the sheet with an edge from the middle of one side into the face, run up and down
  SheetWithLine,       ///< the sheet with a free edge inside
  BoxWithEdge,         ///< the box beside a free edge and a free vertex
  NoShape              ///< an empty compound
};

/// Writes a sample; the extension (.step .iges .brep) chooses the format. Throws std::runtime_error when it fails.
void write_sample(Sample sample, const std::filesystem::path& path);

/// A STEP file of a sample that leaves all parameter curves to its reader.
void write_step_without_parameter_curves(Sample sample, const std::filesystem::path& path);

/// A STEP assembly "gearbox": the part "housing" (a red box whose face at z = 30 is named "lid", is blue and on layer
/// "top") and two instances of the part "shaft" (a green cylinder) 40 and 60 along x.
void write_gearbox(const std::filesystem::path& path);

/// A STEP box of 1 × 2 × 3 inches, in inches.
void write_inch_box(const std::filesystem::path& path);

/// A well-formed STEP file without any shape.
void write_step_without_shape(const std::filesystem::path& path);

}  // namespace tetloom::test
