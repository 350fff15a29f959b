#pragma once
// How well a mesh fits the metrics that its vertices have while it is adapted.
#include <span>

#include "adapt/metric/vertex_metric.hpp"
#include "adapt/parts/mesh_slice.hpp"
#include "adapt/parts/share_in_parts.hpp"
#include "tetloom/adapt.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// As measure_conformity. Memory: 17 bytes per tet for a while. Pre: one metric per point.
MetricConformity conformity_of(const Mesh& mesh, std::span<const VertexMetric> metrics, const BlockLoop& loop);

/// The same of a mesh in parts, known to all ranks: edges count with their owners, and sums of parts are added up in
/// the order of parts. In SharedWork::together.
MetricConformity conformity_of(const PartsWithMetric& parts, const SharedWork& work);

/// That of the whole mesh in the metric at its points, known to all ranks. In together. Memory: 56 bytes per point and
/// 4 per tet of a slice.
MetricConformity conformity_of(const MeshSlice& slice, const SharedWork& work);

}  // namespace tetloom::adapt
