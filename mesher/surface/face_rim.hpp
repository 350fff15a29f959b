#pragma once
// The rim of a face in its parameter plane: the polygon that the face mesher fills.
#include <array>
#include <cstdint>
#include <vector>

#include "mesher/surface/face_mesher.hpp"
#include "tetloom/model.hpp"

namespace tetloom {

/// Seam and pole nodes appear several times, once per place in the parameter plane.
struct FaceRim {
  struct Vertex {
    std::uint32_t node;
    Vec2 uv;
  };
  std::vector<Vertex> vertices;
  std::vector<std::array<std::uint32_t, 2>> segments;  ///< indices of `vertices`, inside on the left
  std::vector<ModelEdgeId> segment_to_edge;
  bool repeats_nodes = false;
};

/// Pre: the face's parametrisation is smooth.
FaceRim trace_rim(const ModelTopology& topology, ModelFaceId face, FaceGeometry& geometry, const RimNodes& rim);

}  // namespace tetloom
