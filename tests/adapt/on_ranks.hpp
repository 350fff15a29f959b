#pragma once
// What tests of adaptation on ranks have in common.
#include <functional>
#include <vector>

#include "tests/support/mixed_mesh.hpp"
#include "tetloom/adapt.hpp"
#include "threading/comm/simulated_ranks.hpp"

namespace tetloom::test {

using Metric = std::function<adapt::Tensor(const Vec3&)>;

inline adapt::Tensor layered(const Vec3& x) {
  const double h = 0.02 + 0.3 * std::abs(x.z - 0.5);
  return adapt::diagonal(40, 40, 1 / (h * h));
}

/// What each rank has afterwards; `host_of` makes a host for each.
inline std::vector<AdaptResult> on_ranks(
    int ranks, const Mesh& mesh, const Metric& metric, const AdaptOptions& options,
    const std::function<Host(int)>& host_of = [](int) { return Host(); }) {
  std::vector<AdaptResult> results(static_cast<std::size_t>(ranks));
  on_simulated_ranks(ranks, [&](Communicator& communicator) {
    const int rank = communicator.rank();
    results[static_cast<std::size_t>(rank)] = adapt_mesh_on_ranks(mesh, metric, options, communicator, host_of(rank));
  });
  return results;
}

inline AdaptOptions in_parts(double tets, int threads = 1) {
  AdaptOptions options;
  options.tets_per_part = tets, options.threads = threads;
  return options;
}

}  // namespace tetloom::test
