#pragma once
// How well a mesh fits the metrics that its vertices have while it is adapted.
#include <span>

#include "adapt/metric/vertex_metric.hpp"
#include "tetloom/adapt.hpp"

namespace tetloom::adapt {

/// As measure_conformity. Memory: 17 bytes per tet for a while. Pre: one metric per point.
MetricConformity conformity_of(const Mesh& mesh, std::span<const VertexMetric> metrics, const BlockLoop& loop);

}  // namespace tetloom::adapt
