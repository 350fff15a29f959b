#pragma once
// Edges at which bodies touch, made as short as a metric asks for before anything else is done.
#include <optional>

#include "adapt/kernel/metric_stage.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/model.hpp"

namespace tetloom::adapt {

/// A mesh in place of the one that was given, and the metric at its points.
struct RefinedInput {
  Mesh mesh;
  MetricField metric;
};

/// Splits edges longer than sqrt 2 at which several umbrellas of tets touch (adapt/parts/umbrellas.hpp), for all
/// umbrellas alike, the longest first: adaptation itself leaves them as they are. New points lie on the edge, or with a
/// model on its edge where that inverts no tet, and edges stay where even the former would; fields on points are
/// interpolated there, those on tets inherited. Points, tets and triangles keep their numbers; what is new comes behind
/// them. Ends when there are `most_tets`, which a metric of very small sizes at few points may reach. Nothing where
/// there is nothing to split. `function`: the metric asked for; empty: `metric`. Pre: the mesh is consistent, the
/// metric one per point.
std::optional<RefinedInput> split_touching_edges(const Mesh& mesh, const MetricField& metric,
                                                 const MetricFunction& function, const GeometricModel* model,
                                                 std::size_t most_tets);

/// Whether several umbrellas touch at edges with an end for which `is_own` is not 0.
bool has_touching_edges(const Mesh& mesh, const std::vector<std::uint8_t>& is_own);

}  // namespace tetloom::adapt
