#pragma once
// What curved faces and edges of a model ask of the metric at vertices on them.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/metric.hpp"

namespace tetloom::adapt {

/// The sizes that one entity of the model asks for at a vertex: none along the directions that are not named.
struct VertexLimit {
  std::uint32_t vert = 0;
  std::array<Vec3, 2> directions{};  ///< orthonormal
  std::array<double, 2> sizes{HUGE_VAL, HUGE_VAL};
};

/// Errors: InvalidArgument.
void require_valid(const CurvatureLimits& limits);

/// The vertices of the elements of each face of the model, and then of each edge, ascending. Errors: InputUnsuitable
/// where the mesh names entities that the model has not.
std::vector<std::vector<std::uint32_t>> verts_by_entity(const Mesh& mesh, const ModelTopology& topology);

/// What one of these faces and edges asks for at its vertices, in their order; of some nothing. An answer depends on
/// those before it in its last bits: where a place is sought begins where the last one was. Thread safety: any number.
std::vector<VertexLimit> limits_of_entity(const GeometricModel& model, std::size_t entity,
                                          std::span<const std::uint32_t> verts, std::span<const Vec3> points,
                                          const CurvatureLimits& limits);

/// Whether it changes the metric.
bool apply(MetricField& metric, const VertexLimit& limit);

}  // namespace tetloom::adapt
