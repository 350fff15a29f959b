#pragma once
// From a mesh and a metric to a mesh whose edges have length 1 in that metric: the one header that a host includes.
//
// Coarsening, refinement, swaps and motion, each iterated (Li, Shephard & Beall 2005), all of them made of one operator
// on cavities (adapt/kernel). The mesh is led to the metric in stages, and dealt to parts anew for every round, each of
// which is changed by its own task but for what it shares with others; the sides of parts lie elsewhere in every round.
//
// Contract: as for mesher.hpp. The mesh depends on the input and the options, and not on the numbers of threads and
// ranks.
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "adapt/kernel/pass_counts.hpp"
#include "adapt/metric/metric_field.hpp"
#include "adapt/transfer/field_transfer.hpp"
#include "core/base/error.hpp"
#include "core/geometry/model.hpp"
#include "core/mesh/mesh.hpp"
#include "threading/task_runner.hpp"
#include "threading/trace.hpp"

namespace tetloom {

struct AdaptOptions {
  double quality_floor = 0.1;  ///< mean ratio in the metric; no collapse, swap or motion makes a tet worse than this,
                               ///< unless it replaces worse ones
  double gradation = 0;        ///< > 1: sizes grow by at most this factor over an edge of unit length; 0: as given
  const GeometricModel* model = nullptr;  ///< new vertices of the boundary are led to it; null: boundaries stay as they
                                          ///< are, and only what lies in planes and on straight edges is changed
  std::vector<std::string> transfer;      ///< fields to be carried over, on points, on tets or on both
  adapt::CellShape cell_shape = adapt::CellShape::Linear;  ///< of fields on tets, while they are carried over
  int threads = 0;                                         ///< 0: all cores that the process may use
  double tets_per_part = 0;                                ///< 0: as it sees fit
  int parts = 0;           ///< of adapt_mesh_in_parts: the result is dealt to so many; 0: as many as the last round had
  Trace* trace = nullptr;  ///< takes what loops and parts did; may be null
};

/// How well a mesh fits a metric. Lengths and mean ratios in the metric (UGAWG's definitions: a tet's metric is that of
/// the corner where its determinant is largest).
struct MetricConformity {
  std::size_t edges = 0;
  double unit = 0;         ///< share of edges with a length in [1/sqrt 2, sqrt 2]
  double half_to_two = 0;  ///< share of those in [1/2, 2]
  double shortest = 0, longest = 0;
  double least_quality = 0, mean_quality = 0;
  std::array<std::size_t, 10> quality_histogram{};  ///< by tenths
  double complexity = 0;                            ///< the integral of sqrt(det M)
};

/// Wall time of the stages.
struct AdaptSeconds {
  double set_up = 0;   ///< checks, and the mesh made ready
  double metric = 0;   ///< of all rounds: the metric at the vertices
  double dealing = 0;  ///< of all rounds: which part has which tets
  double parts = 0;    ///< of all rounds: parts cut out, changed, and put together
  double result = 0;   ///< the mesh handed back, its fields and figures
};

struct AdaptReport {
  MetricConformity before, after;
  adapt::TurningResult turning;  ///< of a metric given at points; `before` and `after` are by what is followed
  adapt::PassCounts operations;
  std::size_t rounds = 0;
  std::size_t most_parts = 0;    ///< of any round
  std::size_t last_parts = 0;    ///< of the last round
  std::size_t beside_model = 0;  ///< vertices of the surface that could not be led all the way to the model
  std::vector<adapt::FieldTransfer> transfers;  ///< fields on points first
  double seconds = 0;
  AdaptSeconds stages;
};

enum class AdaptStatus { Ok, Failed, Cancelled };

struct AdaptResult {
  AdaptStatus status = AdaptStatus::Failed;
  Mesh mesh;  ///< empty unless Ok
  AdaptReport report;
  std::vector<Diagnostic> errors;
};

/// Adapts `mesh`, of tets alone, which stays as it is, to `metric`, one per point, limited where it turns faster than
/// elements can (adapt::limit_turning). Every face of its boundary, and between its regions, must be a triangle that
/// names a model face. Every tet of the result is positive by the exact predicate.
///
/// Errors are in the result: InvalidArgument for options out of range and a metric of another length; InputUnsuitable
/// with a place for meshes that cannot be adapted, for tags of entities above 2^28 and for fields on tets that are not
/// finite; Cancelled; OutOfMemory.
/// Thread safety: may be called from any thread, several calls at once.
AdaptResult adapt_mesh(const Mesh& mesh, const adapt::MetricField& metric, const AdaptOptions& options,
                       const Host& host = {});

/// The same with the metric at any place, called from many threads at once. It must be symmetric positive definite.
AdaptResult adapt_mesh(const Mesh& mesh, const std::function<adapt::Tensor(const Vec3&)>& metric,
                       const AdaptOptions& options, const Host& host = {});

/// How well `mesh` fits `metric`, one per point. Pre: sizes fit.
MetricConformity measure_conformity(const Mesh& mesh, const adapt::MetricField& metric,
                                    const BlockLoop& loop = serial_loop());

}  // namespace tetloom
