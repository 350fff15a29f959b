#pragma once
// What there is at the vertices of a share, found while a rank has the whole mesh.
#include <cstdint>
#include <vector>

#include "adapt/metric/start_grid.hpp"
#include "adapt/parts/fans.hpp"
#include "adapt/parts/share.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

struct ShareVerts {
  std::vector<std::uint32_t> to_given;  ///< number in the mesh that was given; those that fans made of one have the same
  bool has_metric = false;              ///< the same on all ranks
  std::vector<Tensor> logs;             ///< of the metric; none where there is none
  std::vector<Tensor> implied;          ///< logarithms; see ImpliedMetric
  std::vector<std::uint32_t> to_start;  ///< number of a tet near by
};

/// Of a mesh of `given` points, before it is shared out.
struct WholeFindings {
  std::size_t given = 0;
  StartGrid grid;
  std::vector<Tensor> implied;
};
WholeFindings find_in_whole(const WholeMesh& whole, const TouchingVerts& touching, std::size_t given,
                            const TaskRunner& runner);

/// `metric`: one per point that was given, or none.
ShareVerts verts_of_share(const WholeMesh& share, const ShareLinks& links, const TouchingVerts& touching,
                          const WholeFindings& found, const MetricField& metric);

}  // namespace tetloom::adapt
