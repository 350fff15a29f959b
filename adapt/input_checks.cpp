#include "adapt/input_checks.hpp"

#include <array>
#include <cstdio>
#include <string>

#include "core/mesh/mesh_access.hpp"
#include "core/part/part_mesh.hpp"
#include "mesher/sizing/mesh_estimate.hpp"

namespace tetloom::adapt {

namespace {

constexpr double kBytesPerTet = 200;  // at the least

}  // namespace

void check_mesh(const Mesh& mesh, const BlockLoop& loop) {
  require_consistent(mesh, loop);
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (!is_finite(mesh.points[v]))
      throw Error(Diagnostic{ErrorCode::InputUnsuitable, "the mesh has points that are not finite", {}, {}, {v}});
  if (mesh.tet_to_vert.empty()) throw Error(ErrorCode::InputUnsuitable, "the mesh has no tetrahedra");
}

void check_metric(const MetricField& metric, const Mesh& mesh) {
  if (metric.size() != mesh.points.size())
    throw Error(ErrorCode::InvalidArgument, "the metric has " + std::to_string(metric.size()) + " values for " +
                                                std::to_string(mesh.points.size()) + " points");
  for (std::size_t v = 0; v < metric.size(); ++v)
    if (!is_finite(metric.logs[v]))
      throw Error(
          Diagnostic{ErrorCode::InputUnsuitable, "the metric is not finite at a point", {}, mesh.points[v], {v}});
}

void check_complexity(double complexity) {
  const double tets = expected_tets(complexity);
  if (!(tets < static_cast<double>(CellPlace::kMaxTets))) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", tets);
    throw Error(ErrorCode::OutOfMemory, std::string("the metric asks for about ") + text.data() +
                                            " tetrahedra, more than can be counted; ask for larger sizes");
  }
  MeshEstimate estimate;
  estimate.tets = tets, estimate.bytes = kBytesPerTet * tets;
  check_memory(estimate, 0);
}

}  // namespace tetloom::adapt
