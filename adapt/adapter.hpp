#pragma once
// The rounds of one adaptation.
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "adapt/kernel/passes.hpp"
#include "adapt/metric/background.hpp"
#include "adapt/parts/mesh_slice.hpp"
#include "adapt/parts/rounds.hpp"
#include "adapt/parts/share_in_parts.hpp"
#include "adapt/parts/start_metric.hpp"
#include "adapt/parts/umbrellas.hpp"
#include "adapt/transfer/field_transfer.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// What adaptation starts from on a single rank.
struct AdapterInput {
  const Mesh& mesh;          ///< of which fields, regions, names and sides are referred to
  Mesh* given_up = nullptr;  ///< the same, where nobody needs it any more: all else in it is freed on the way
  MetricField metric;        ///< one per point
};

/// What adaptation starts from on one of several ranks.
struct AdapterShare {
  Mesh source;  ///< names and sides, and fields without values
  WholeMesh mesh;
  ShareLinks links;
  TouchingVerts touching;
  std::unique_ptr<BackgroundTiles> tiles;
  FirstStage first_stage;
  FieldsBefore fields_before;
};

/// In SharedWork::together. `function`: as of Adapter. Errors: those of Adapter.
AdapterShare share_of(MeshSlice&& slice, const MetricFunction& function, const AdaptOptions& options,
                      const SharedWork& work);

/// Leads a mesh to a metric in stages, each of a few rounds (docs/decisions/0006), until it fits or gets no better.
/// With ranks, all of them construct it and call it in SharedWork::together.
class Adapter {
 public:
  /// Refers to all of these but the metric. `function`: the metric asked for; empty: that of the input. Pre: what
  /// input_checks asks for. Errors: InputUnsuitable for a mesh that does not fit together, or that the model does not
  /// fit; Cancelled.
  Adapter(AdapterInput&& input, const MetricFunction& function, const AdaptOptions& options, const SharedWork& work);
  Adapter(AdapterShare&& share, const MetricFunction& function, const AdaptOptions& options, const SharedWork& work);

  /// Adapts, and fills in what the report says of fields, operations, rounds and stages.
  void run(AdaptReport& report);

  // Afterwards, one of these.

  /// The mesh and the metric at its points, on rank 0; nothing on the others.
  struct Whole {
    Mesh mesh;
    GrowingArray<VertexMetric> metric;
  };
  Whole take_whole();
  /// The mesh in the parts of the last round, without anything in one place.
  PartsWithMetric take_parts();

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

  void keep_background(std::size_t given, MetricField&& metric);
  template <class LookUp>
  void look_up_verts(const LookUp& look_up, bool needs_tiles = true);
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
  void carry_fields(AdaptReport& report);
  void note_rounds(AdaptReport& report) const;
  PassCounts sum_of(const PassCounts& counts) const;

  const Mesh source_;  // where nobody else has it
  const Mesh& mesh_;
  const MetricFunction& function_;
  const AdaptOptions& options_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  WholeMesh whole_;  // between rounds the share of it that this rank has
  TouchingVerts touching_;
  ShareLinks links_;
  std::vector<Tensor> implied_;
  FieldsBefore fields_before_;
  std::unique_ptr<BackgroundTiles> tiles_;  // where several ranks have the background
  std::optional<BackgroundMesh> background_;
  std::optional<FieldCarrier> carrier_;
  CarriedFields carried_;            // for this rank's share, after the last round
  PassCounts counts_, last_counts_;  // of this rank: of all rounds, of the last one
  FirstStage first_stage_;
  double ratio_;  // of the stage that vertices have the metric of
  std::size_t rounds_ = 0, most_parts_ = 0, last_parts_ = 0;
  AdaptSeconds seconds_;
};

}  // namespace tetloom::adapt
