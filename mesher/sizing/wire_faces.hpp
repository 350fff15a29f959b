#pragma once
// Faces around something so thin that the floor of sizes would take its shape. Private to mesher/sizing.
#include <vector>

#include "mesher/sizing/size_targets.hpp"
#include "tetloom/model.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// What all wires of a model may take.
struct WireBudget {
  double most_triangles = 150'000;
  double least_per_turn = 8;
};

/// The edges per turn that wires may have: all that are asked for while all wires together take no more triangles than
/// the budget, fewer where they would take more, but at least its least; 0, so that the floor stays, where those are
/// far too many. `weights` of the faces of wires: the integral of the squared largest curvature.
double wire_edges_per_turn(const std::vector<double>& weights, double wanted, const WireBudget& budget = {});

/// `SizeTargets::wires`: the faces around wires and balls so thin that the size asked for would take much of their
/// volume. They get ten edges per turn, or fewer, down to six, where all together would take more than
/// `most_triangles`. Empty: there are none, or far too many. A few samples of each curved face.
std::vector<double> find_wires(const GeometricModel& model, const SizeTargets& targets, double most_triangles,
                               const SharedWork& work);

/// Finds wires and balls among the faces that the curvature rule wants finer than the floor. Immutable; any thread.
class WireFinder {
 public:
  WireFinder(const GeometricModel& model, const SizeTargets& targets);

  /// The integral of the squared curvature over the face if it is of a wire, else 0.
  double weight(ModelFaceId face, FaceGeometry& geometry, const Tessellation& facets) const;

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
