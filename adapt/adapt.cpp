#include "tetloom/adapt.hpp"

#include <algorithm>
#include <cmath>

#include "adapt/adapter.hpp"
#include "adapt/conformity.hpp"
#include "adapt/input_checks.hpp"
#include "adapt/result_check.hpp"
#include "adapt/touching_edges.hpp"
#include "core/base/failure.hpp"
#include "core/base/stopwatch.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/codec.hpp"

namespace tetloom {

namespace {

using namespace adapt;

void check_options(const AdaptOptions& options) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); };
  if (!(options.quality_floor >= 0 && options.quality_floor < 1)) refuse("the quality floor must be in [0, 1)");
  if (options.gradation != 0 && !(options.gradation > 1)) refuse("the gradation must be above 1, or 0 for none");
  if (options.threads < 0) refuse("the number of threads must not be negative");
  if (!(options.tets_per_part >= 0)) refuse("the number of tets per part must not be negative");
  if (options.parts < 0) refuse("the number of parts must not be negative");
}

template <class Run>
AdaptResult guarded(const Run& run) {
  AdaptResult result;
  Stopwatch watch;
  const std::optional<Diagnostic> failure = failure_of([&] { run(result); });
  if (!failure) {
    result.status = AdaptStatus::Ok;
  } else {
    result.errors.push_back(*failure);
    result.status = failure->code == ErrorCode::Cancelled ? AdaptStatus::Cancelled : AdaptStatus::Failed;
    result.mesh = Mesh();
  }
  result.report.seconds = watch.lap();
  return result;
}

// What ranks give differs where they read different files, say; it would leave them waiting for each other.
void require_same_input(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options,
                        const SharedWork& work) {
  if (work.rank_count() == 1) return;
  std::uint64_t own = 0;
  work.each([&] { own = fingerprint(mesh, metric, options, work.runner()); });
  for (const Bytes& bytes : work.all_gather([&](MessageWriter& writer) { writer.put(own); }))
    if (MessageReader(bytes).get<std::uint64_t>() != own)
      throw Error(ErrorCode::InvalidArgument, "the ranks were not given the same mesh, metric and options");
}

void put_findings(const AdaptReport& report, MessageWriter& writer) {
  writer.put(report.after);
  writer.put(static_cast<std::uint64_t>(report.transfers.size()));
  for (const FieldTransfer& field : report.transfers) {
    put_text(writer, field.name);
    writer.put(field.on_cells);
    writer.put_array(std::span<const FieldTransfer::Component>(field.components));
  }
}

// What rank 0 has found out about the mesh, for all.
void share_findings(AdaptReport& report, const SharedWork& work) {
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) { put_findings(report, writer); });
  if (work.rank() == 0) return;
  MessageReader reader(given[0]);
  report.after = reader.get<MetricConformity>();
  report.transfers.resize(reader.get<std::uint64_t>());
  for (FieldTransfer& field : report.transfers) {
    field.name = get_text(reader);
    field.on_cells = reader.get<bool>();
    field.components = reader.get_array<FieldTransfer::Component>();
  }
}

class AdaptRun {
 public:
  AdaptRun(const Mesh& mesh, const MetricField* given, const MetricFunction& function, const AdaptOptions& options,
           const SharedWork& work)
      : mesh_(mesh), given_(given), function_(function), options_(options), work_(work) {}

  void run(AdaptResult& result) {
    Stopwatch watch;
    work_.each([&] { prepare(result.report); });
    require_same_input(mesh_, metric_, options_, work_);
    measure_before(result.report);
    std::optional<Adapter> adapter;
    work_.each([&] {
      split_touching(result.report.before.complexity);
      adapter.emplace(refined_ ? refined_->mesh : mesh_, refined_ ? refined_->metric : metric_, function_, options_,
                      work_);
    });
    result.report.stages.set_up = watch.lap();
    adapter->run(result);
    watch.lap();
    work_.each([&] {
      if (work_.rank() != 0) return;
      check_positive(result.mesh, work_.runner_for_one());
      result.report.after = conformity_of(result.mesh, adapter->metric_of_result(), work_.runner_for_one());
    });
    share_findings(result.report, work_);
    result.report.stages.result += watch.lap();
  }

 private:
  void prepare(AdaptReport& report) {
    const TaskRunner& runner = work_.runner();
    check_options(options_);
    check_mesh(mesh_, runner);
    check_transfer(mesh_, options_.transfer);
    metric_ = given_ ? *given_ : metric_from_function(function_, mesh_.points, runner);
    check_metric(metric_, mesh_);
    if (!given_) return;
    const TetView view{mesh_.points, mesh_.tet_to_vert};
    if (options_.gradation > 0)
      limit_gradation(metric_, mesh_.points, VertexGraph(view, runner), options_.gradation, runner);
    report.turning = limit_turning(metric_, view, runner);
  }

  // On the first rank, for all.
  void measure_before(AdaptReport& report) {
    work_.each([&] {
      if (work_.rank() == 0) report.before = measure_conformity(mesh_, metric_, work_.runner_for_one());
    });
    const auto given = work_.all_gather([&](MessageWriter& writer) { writer.put(report.before); });
    if (work_.rank() != 0) report.before = MessageReader(given[0]).get<MetricConformity>();
    work_.each([&] { check_complexity(report.before.complexity); });
  }

  void split_touching(double complexity) {
    const double most = static_cast<double>(mesh_.tet_to_vert.size()) + kMostOfTouching * expected_tets(complexity);
    refined_ = split_touching_edges(mesh_, metric_, function_, options_.model, static_cast<std::size_t>(most));
    // Errors name elements of the mesh that was given.
    if (refined_) make_whole_mesh(mesh_, work_.runner());
  }

  static constexpr double kMostOfTouching = 2;  // times the tets that the metric asks for

  const Mesh& mesh_;
  const MetricField* given_;
  const MetricFunction& function_;
  const AdaptOptions& options_;
  const SharedWork& work_;
  MetricField metric_;
  std::optional<RefinedInput> refined_;
};

AdaptResult adapt_to(const Mesh& mesh, const MetricField* given, const MetricFunction& function,
                     const AdaptOptions& options, Communicator* ranks, const Host& host) {
  return guarded([&](AdaptResult& result) {
    const SharedWork work(std::max(0, options.threads), host, ranks, options.trace);
    work.together([&] { AdaptRun(mesh, given, function, options, work).run(result); });
  });
}

}  // namespace

AdaptResult adapt_mesh(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options, const Host& host) {
  return adapt_to(mesh, &metric, {}, options, nullptr, host);
}

AdaptResult adapt_mesh(const Mesh& mesh, const std::function<Tensor(const Vec3&)>& metric, const AdaptOptions& options,
                       const Host& host) {
  return adapt_to(mesh, nullptr, metric, options, nullptr, host);
}

AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options,
                                Communicator& ranks, const Host& host) {
  return adapt_to(mesh, &metric, {}, options, &ranks, host);
}

AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const std::function<Tensor(const Vec3&)>& metric,
                                const AdaptOptions& options, Communicator& ranks, const Host& host) {
  return adapt_to(mesh, nullptr, metric, options, &ranks, host);
}

}  // namespace tetloom
