#pragma once
// What there is at the vertices of a share, found while a rank has the mesh that was given.
#include <cstdint>
#include <vector>

#include "adapt/parts/fans.hpp"
#include "adapt/parts/share.hpp"
#include "adapt/transfer/field_transfer.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

struct ShareVerts {
  std::vector<std::uint32_t>
      to_given;                 ///< number in the mesh that was given; those that fans made of one have the same
  bool has_metric = false;      ///< the same on all ranks
  std::vector<Tensor> logs;     ///< of the metric; none where there is none
  std::vector<Tensor> implied;  ///< logarithms; see ImpliedMetric
  std::size_t components = 0;   ///< of all fields that are carried over
  std::vector<double> fields;   ///< their values, all components of a vertex side by side
  std::vector<std::uint32_t> to_start;  ///< number of a tet near by
};

/// At the points for which `is_own` is not 0, ascending. `metric`: one per point, or none. `fields`: to be filled in. A
/// rank needs 12 bytes for each tet of the whole meanwhile. Pre: all tets have volumes, or nobody uses what this says.
ShareVerts verts_of_mesh(const Mesh& mesh, const std::vector<std::uint8_t>& is_own, const MetricField& metric,
                         FiguresBefore& fields, const TaskRunner& runner);

/// The same as the vertices stand in the share that has these tets, where the mesh had `given` points before fans had
/// vertices of their own.
ShareVerts as_in_share(const ShareVerts& verts, const WholeMesh& share, const ShareLinks& links,
                       const TouchingVerts& touching, std::size_t given);

}  // namespace tetloom::adapt
