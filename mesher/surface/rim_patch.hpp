#pragma once
// A smooth face before anything is inside: its rim with places, and the triangulation of the plane polygon.
#include <span>

#include "core/spatial/constrained_delaunay.hpp"
#include "mesher/surface/face_mesher.hpp"
#include "mesher/surface/face_rim.hpp"
#include "mesher/surface/patch.hpp"

namespace tetloom {

/// The rim of a face and what it bounds in the plane.
struct RimPatch {
  FaceRim rim;
  Vec2 scale{1, 1};                   ///< from (u,v) to the plane, axis by axis
  std::vector<PatchVertex> vertices;  ///< as those of `rim`; they lie where their nodes lie
  PolygonTriangulation polygon;
};

/// Pre: the face's parametrisation is smooth.
RimPatch make_rim_patch(const ModelTopology& topology, ModelFaceId face, FaceGeometry& geometry, const RimNodes& rim,
                        const SizeField& sizes);

/// As make_rim_patch, from a rim whose places are those of `geometry`; `nodes` are the points of its nodes.
RimPatch fill_rim_patch(FaceRim rim, FaceGeometry& geometry, std::span<const Vec3> nodes, const SizeField& sizes);

/// Room for the vertices that the area calls for at the sizes on the rim.
void reserve_expected(Patch& patch);

}  // namespace tetloom
