#pragma once
// The metric of one size everywhere.
#include <vector>

#include "tetloom/adapt.hpp"

namespace tetloom::test {

inline adapt::MetricField uniform_metric(const Mesh& mesh, double h) {
  return adapt::metric_from_sizes(std::vector<double>(mesh.points.size(), h), mesh.points);
}

}  // namespace tetloom::test
