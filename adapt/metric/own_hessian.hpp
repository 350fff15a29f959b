#pragma once
// The metric of a solution on a mesh of which this rank has its own tets and those around them.
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/metric/own_tets.hpp"
#include "adapt/metric/own_verts.hpp"

namespace tetloom::adapt {

/// What of the mesh at hand is this rank's own; by itself: all of it, and one rank.
struct OwnMesh {
  OwnTets tets;
  OwnVerts verts;
  const std::vector<std::uint8_t>* counted = nullptr;  ///< vertices of which this rank is the owner

  bool counts(std::size_t vert) const { return counted == nullptr || (*counted)[vert] != 0; }
};

/// Of the vertices `verts` alone. As recover_hessian, where `graph` knows the neighbours of all vertices within two
/// edges of them. The values must be finite.
std::vector<Tensor> recover_hessian_at(std::span<const std::uint32_t> verts, std::span<const double> values,
                                       const TetView& mesh, const VertexGraph& graph, const BlockLoop& loop);

/// As in metric.hpp, of all ranks together; the same on all of them, bit by bit, as of one that has it all. Collective
/// calls. `mesh`, `graph`: of all tets at the vertices of own tets, ascending in the whole mesh.
double scale_to_complexity(MetricField& metric, const TetView& mesh, double target, const MetricBounds& bounds,
                           const OwnMesh& own, const BlockLoop& loop);
HessianMetric metric_from_hessian(std::span<const Tensor> hessians, double flat, const TetView& mesh,
                                  const VertexGraph& graph, const HessianOptions& options, const OwnMesh& own,
                                  const BlockLoop& loop);

/// The second derivatives that count as none, where values range from `low` to `high` over a mesh of that diagonal.
double flat_curvature(double low, double high, double diagonal);

/// Around all points of all ranks.
double diagonal_of(std::span<const Vec3> points, const OwnTets& own);

}  // namespace tetloom::adapt
