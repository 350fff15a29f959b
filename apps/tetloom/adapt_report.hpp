#pragma once
// What the report and a person are told of a run of `adapt`.
#include <string>

#include "apps/tetloom/report.hpp"
#include "tetloom/adapt.hpp"

namespace tetloom::app {

/// {"turning_limited": null or {"complexity_asked", "complexity_followed"} for a metric that turns faster than elements
/// can, of which no size is larger than the mesh, "before": {…}, "after": {…}, "operations": {"splits": {"done",
/// "refused", "refused_by": {reason: count, …}}, …}, "rounds", "most_parts", "points_beside_model", "transfer":
/// [{"name", "on": "points" or "cells", "components":
/// [{"integral", "least", "greatest": [before, after], "change"}, …]}, …], "seconds": {"metric", "adapt"}}, where
/// "change" is that of the integral as a share of the integral of the magnitude; before and after have {"edges",
/// "unit_edges", "half_to_two", "shortest", "longest", "quality_min", "quality_mean", "quality_histogram",
/// "complexity"}, where "unit_edges" is the share of edges with a length in [0.707, 1.414] and "half_to_two" that in
/// [0.5, 2], and qualities are mean ratios in the metric.
nlohmann::ordered_json adaptation_json(const AdaptReport& adaptation, double metric_seconds);

/// The mesh before and after beside each other, the histogram of qualities, operations, time and files.
std::string render_adaptation(const AdaptReport& adaptation, const RunReport& report, const std::string& output,
                              const std::string& report_file);

}  // namespace tetloom::app
