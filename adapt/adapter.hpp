#pragma once
// The rounds of one adaptation.
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "adapt/kernel/passes.hpp"
#include "adapt/metric/background.hpp"
#include "adapt/parts/fans.hpp"
#include "adapt/parts/rounds.hpp"
#include "adapt/transfer/field_transfer.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// Leads a mesh to a metric in stages, each of a few rounds (docs/decisions/0006), until it fits or gets no better.
/// With ranks, all of them construct it inside of SharedWork::each and run it in together.
class Adapter {
 public:
  /// Refers to all of these but `metric`. `function`: the metric asked for; empty: `metric`. Pre: what input_checks
  /// asks for. Errors: InputUnsuitable for a mesh that does not fit together, or that the model does not fit;
  /// Cancelled.
  Adapter(const Mesh& mesh, const MetricField& metric, const MetricFunction& function, const AdaptOptions& options,
          const SharedWork& work);

  /// Fills in the mesh, on rank 0, and what the report says of operations, rounds and stages.
  void run(AdaptResult& result);
  /// At the points of the result; on rank 0, after `run`.
  std::span<const VertexMetric> metric_of_result() const { return metric_of_result_; }

 private:
  // What is done in one round.
  struct Work {
    std::function<void(Passes&)> passes;  // to each part
    double longest = HUGE_VAL;            // of the edges between parts
  };

  // How well the mesh fits: the shares of edges with lengths in [1/sqrt 2, sqrt 2] and [1/2, 2], each counted by every
  // tet that has it, and the worst cubed mean ratio.
  struct Fit {
    double unit = 0, half_to_two = 0, least_quality = 0;
    bool is_good() const;
    bool is_better_than(const Fit& other) const;
  };

  double refinement();
  void follow_stages();
  void approach_metric();
  void snap_to_model();
  void round(double ratio, const Work& work);
  void set_metric(const MetricStage& stage);
  double count_tets() const;
  GrowingArray<float> work_per_tet() const;
  Fit measure() const;
  std::vector<double> gather(std::vector<double>&& own) const;
  CarriedFields carry_fields(const FieldCarrier& carrier);
  void finish_result(AdaptResult& result);
  PassCounts sum_of(const PassCounts& counts) const;

  const Mesh& mesh_;
  const MetricFunction& function_;
  const AdaptOptions& options_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  WholeMesh whole_;  // between rounds the share of it that this rank has
  GrowingArray<VertexMetric> metric_of_result_;
  TouchingVerts touching_;
  ShareLinks links_;
  std::vector<Tensor> implied_;
  std::optional<BackgroundMesh> background_;
  PassCounts counts_, last_counts_;  // of this rank: of all rounds, of the last one
  double ratio_ = 0;                 // of the last round
  std::size_t rounds_ = 0, most_parts_ = 0, last_parts_ = 0;
  AdaptSeconds seconds_;
};

}  // namespace tetloom::adapt
