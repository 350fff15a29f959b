#pragma once
// From a mesh and a metric to a mesh whose edges have length 1 in that metric.
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tetloom/communicator.hpp"
#include "tetloom/error.hpp"
#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/model.hpp"
#include "tetloom/partition.hpp"

// What passes did, and what they were refused.

namespace tetloom::adapt {

/// What became of an attempt, in the order in which it is asked.
enum class Verdict : std::uint8_t {
  Done,
  Frozen,          ///< a vertex, edge or face that has to stay
  Classification,  ///< the model does not allow it
  TooLarge,        ///< more than Cavity::kMostTets tets
  Inverted,        ///< a tet would have no volume
  Quality,         ///< a tet would be worse than bearable
  Length,          ///< an edge would become too long or too short
  Surface,         ///< the surface would fold, leave the model or meet itself
  NoGain,
  Count
};
/// "done", "frozen" … in snake case, for reports.
std::string_view to_string(Verdict verdict);

/// How many attempts had each outcome.
using Verdicts = std::array<std::size_t, static_cast<std::size_t>(Verdict::Count)>;

/// What became of the operations that were tried.
struct PassCounts {
  Verdicts splits{}, collapses{}, swaps{}, moves{};
  std::size_t unsnapped = 0;  ///< times that a vertex of the surface was not moved all the way to the model

  void add(const PassCounts& other) {
    for (const auto counts : {&PassCounts::splits, &PassCounts::collapses, &PassCounts::swaps, &PassCounts::moves})
      for (std::size_t i = 0; i < splits.size(); ++i) (this->*counts)[i] += (other.*counts)[i];
    unsnapped += other.unsnapped;
  }
};

/// How values on tets are understood between the centres.
enum class CellReconstruction {
  Constant,  ///< one value all over each tet: first order
  Linear,    ///< with a gradient that makes no new extremes: second order where the field is smooth
};

/// One component of a field, on one mesh. The integral is over all tets, of a point field as it is interpolated.
struct FieldFigures {
  double integral = 0;
  double least = 0, greatest = 0;  ///< values
  double magnitude = 0;            ///< the integral of the magnitude
};

/// What has become of one field.
struct FieldTransfer {
  std::string name;
  bool on_cells = false;  ///< else on points
  struct Component {
    FieldFigures before, after;
    /// How far the integral has changed, as a share of that of the magnitude before.
    double change() const {
      const double by = after.integral - before.integral;
      return by == 0 || before.magnitude == 0 ? by : by / before.magnitude;
    }
  };
  std::vector<Component> components;
};

}  // namespace tetloom::adapt

// What is done with the mesh.
//
// Coarsening, refinement, swaps and motion, each iterated (Li, Shephard & Beall 2005), all of them made of one operator
// on cavities (adapt/kernel). The mesh is led to the metric in stages, and dealt to parts anew for every round, each of
// which is changed by its own task but for what it shares with others; the sides of parts lie elsewhere in every round.
//
// Contract: as for tetloom/mesh.hpp. The mesh depends on the input and the options, and not on the numbers of threads
// and ranks.

namespace tetloom {

class Trace;

/// How a mesh is adapted.
struct AdaptOptions {
  double quality_floor = 0.1;  ///< mean ratio in the metric; no collapse, swap or motion makes a tet worse than this,
                               ///< unless it replaces worse ones
  double gradation = 0;        ///< > 1: sizes grow by at most this factor over an edge of unit length; 0: as given
  const GeometricModel* model = nullptr;  ///< new vertices of the boundary are snapped to it; null: boundaries stay as
                                          ///< they are, and only what lies in planes and on straight edges is changed
  std::optional<adapt::CurvatureLimits> curvature;  ///< a metric at points becomes finer where the model is curved, see
                                                    ///< limit_by_curvature; before gradation
  std::vector<std::string> transfer;                ///< fields to be carried over, on points, on tets or on both
  adapt::CellReconstruction cell_reconstruction =
      adapt::CellReconstruction::Linear;  ///< of fields on tets, while they are carried over
  int threads = 0;                        ///< 0: all cores that the process may use
  double tets_per_part = 0;               ///< 0: as it sees fit
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

/// What an adaptation has done, and how well the mesh fits the metric before and after.
struct AdaptReport {
  MetricConformity before, after;
  adapt::TurningResult turning;  ///< of a metric given at points; `before` and `after` are by what is followed
  adapt::PassCounts operations;
  std::size_t rounds = 0;
  std::size_t most_parts = 0;    ///< of any round
  std::size_t last_parts = 0;    ///< of the last round
  std::size_t beside_model = 0;  ///< vertices of the surface that could not be moved all the way to the model
  std::vector<adapt::FieldTransfer> transfers;  ///< fields on points first
  double seconds = 0;
  AdaptSeconds stages;
};

enum class AdaptStatus { Ok, Failed, Cancelled };

/// The adapted mesh, or why there is none.
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

// adapt_mesh by several ranks together, and for results in parts.

/// As adapt_mesh, by all ranks together: parts of the mesh are dealt to them anew for every round. All of them give the
/// same mesh, metric and options; of that mesh each keeps a slice. What comes out is the mesh of one process, bit for
/// bit, on rank 0, and an empty one on the others; all else in the result is the same on all ranks, but for the time.
///
/// A collective call. Errors: also InvalidArgument, where ranks give different meshes, metrics or options; what happens
/// to one rank, its host's wish to stop too, is the same error on all of them. Thread safety: one call for each
/// communicator.
AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const adapt::MetricField& metric, const AdaptOptions& options,
                                Communicator& ranks, const Host& host = {});
AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const std::function<adapt::Tensor(const Vec3&)>& metric,
                                const AdaptOptions& options, Communicator& ranks, const Host& host = {});
/// The same for a mesh and a metric that are not needed any more: both are given back to the system as it goes, which
/// saves half of the memory that the mesh takes on every rank. What is left of them is not defined.
AdaptResult adapt_mesh_on_ranks(Mesh&& mesh, adapt::MetricField&& metric, const AdaptOptions& options,
                                Communicator& ranks, const Host& host = {});

/// The same of a mesh that lies in parts, which is emptied, and the metric at the vertices of each of them. No rank has
/// more of it than its parts and its share, but where bodies touch in edges longer than the metric asks for: then each
/// has all for a while. The mesh is that of the whole one with points by global id and tets part by part. Errors: also
/// InvalidArgument for a metric of other parts, and those of link_parts; elements are not named.
AdaptResult adapt_mesh_on_ranks(PartitionedMesh&& mesh, PerPart<adapt::MetricField>&& metric,
                                const AdaptOptions& options, const Host& host = {});
AdaptResult adapt_mesh_on_ranks(PartitionedMesh&& mesh, const std::function<adapt::Tensor(const Vec3&)>& metric,
                                const AdaptOptions& options, const Host& host = {});
/// To the metric that adapt::metric_from_solution makes of a field on the points. Errors: also InputUnsuitable, where
/// there is no such field or it has several components, and those of adapt::metric_from_solution.
AdaptResult adapt_mesh_on_ranks(PartitionedMesh&& mesh, const adapt::SolutionMetric& metric,
                                const AdaptOptions& options, const Host& host = {});

/// The adapted mesh in parts, or why there is none.
struct AdaptInPartsResult {
  AdaptResult run;                      ///< as of adapt_mesh_on_ranks, without the mesh
  std::optional<PartitionedMesh> mesh;  ///< when the run's status is Ok
  double partition_seconds = 0;         ///< of dealing the mesh to parts
};

/// The same mesh in `options.parts` parts of equal numbers of tets, for the next solve: the parts of the last round as
/// they are, where they are as many and within 3 % of equal, and dealt anew otherwise. Global ids of vertices are their
/// numbers in the mesh of adapt_mesh. No rank has more of the result than its parts. The parts do not depend on the
/// numbers of threads and ranks. A collective call; errors as above.
AdaptInPartsResult adapt_mesh_in_parts(const Mesh& mesh, const adapt::MetricField& metric, const AdaptOptions& options,
                                       Communicator& ranks, const Host& host = {});
AdaptInPartsResult adapt_mesh_in_parts(const Mesh& mesh, const std::function<adapt::Tensor(const Vec3&)>& metric,
                                       const AdaptOptions& options, Communicator& ranks, const Host& host = {});
/// The same for a mesh and a metric that are not needed any more, see adapt_mesh_on_ranks.
AdaptInPartsResult adapt_mesh_in_parts(Mesh&& mesh, adapt::MetricField&& metric, const AdaptOptions& options,
                                       Communicator& ranks, const Host& host = {});
/// From parts to parts, see adapt_mesh_on_ranks.
AdaptInPartsResult adapt_mesh_in_parts(PartitionedMesh&& mesh, PerPart<adapt::MetricField>&& metric,
                                       const AdaptOptions& options, const Host& host = {});
AdaptInPartsResult adapt_mesh_in_parts(PartitionedMesh&& mesh, const std::function<adapt::Tensor(const Vec3&)>& metric,
                                       const AdaptOptions& options, const Host& host = {});
AdaptInPartsResult adapt_mesh_in_parts(PartitionedMesh&& mesh, const adapt::SolutionMetric& metric,
                                       const AdaptOptions& options, const Host& host = {});

}  // namespace tetloom
