#pragma once
// Faces around something so thin that the floor of sizes would take its shape. Private to mesher/sizing.
#include <vector>

#include "core/geometry/model.hpp"
#include "mesher/sizing/size_targets.hpp"

namespace tetloom {

/// Finds wires and balls among the faces that the curvature rule wants finer than the floor. Immutable; any thread.
class WireFinder {
 public:
  WireFinder(const GeometricModel& model, const SizeTargets& targets);

  /// Whether the face goes around a wire or a ball, alone or with its neighbours: opposite to it, through the material
  /// and one diameter of curvature away, is the face itself or one that shares an edge with it. Asked of `facets`,
  /// those of the face. Never where the floor was asked for. Complexity: a few projections.
  bool is_wire(ModelFaceId face, FaceGeometry& geometry, const Tessellation& facets) const;

 private:
  std::vector<ModelFaceId> neighbors(ModelFaceId face) const;

  const GeometricModel& model_;
  const SizeTargets& targets_;
  std::vector<std::vector<ModelFaceId>> edge_to_faces_;
};

}  // namespace tetloom
