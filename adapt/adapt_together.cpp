#include "adapt/adapt_together.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "adapt/conformity.hpp"
#include "adapt/input_checks.hpp"
#include "adapt/metric/curvature_limits.hpp"
#include "adapt/parts/slice_curvature.hpp"
#include "adapt/parts/slice_gradation.hpp"
#include "adapt/parts/slice_hessian.hpp"
#include "adapt/touching_edges.hpp"
#include "core/base/free_memory.hpp"
#include "threading/parts/gather_mesh.hpp"

namespace tetloom::adapt {

namespace {

void check_options(const AdaptOptions& options) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); };
  if (!(options.quality_floor >= 0 && options.quality_floor < 1)) refuse("the quality floor must be in [0, 1)");
  if (options.gradation != 0 && !(options.gradation > 1)) refuse("the gradation must be above 1, or 0 for none");
  if (options.threads < 0) refuse("the number of threads must not be negative");
  if (!(options.tets_per_part >= 0)) refuse("the number of tets per part must not be negative");
  if (options.parts < 0) refuse("the number of parts must not be negative");
  if (options.curvature && options.model == nullptr) refuse("limits by curvature need a model");
  if (options.curvature) require_valid(*options.curvature);
}

// What ranks give differs where they read different files, say; it would leave them waiting for each other.
void require_same(std::uint64_t own, const SharedWork& work) {
  for (const Bytes& bytes : work.all_gather([&](MessageWriter& writer) { writer.put(own); }))
    if (MessageReader(bytes).get<std::uint64_t>() != own)
      throw Error(ErrorCode::InvalidArgument, "the ranks were not given the same mesh, metric and options");
}

// From a call to an adapter that is ready to run.
class Start {
 public:
  Start(const AdaptCall& call, const SharedWork& work, AdaptReport& report)
      : call_(call), options_(call.options), work_(work), runner_(work.runner()), report_(report) {}

  Adapter& run() {
    give_back_where_shared(work_.rank_count());
    work_.each([&] { check_options(options_); });
    call_.parts ? start_from_parts() : start_from_mesh();
    give_back_where_shared(work_.rank_count());
    return *adapter_;
  }

 private:
  bool is_alone() const { return work_.rank_count() == 1; }

  void start_from_mesh() {
    MetricField metric;
    work_.each([&] {
      check_mesh(*call_.mesh, runner_);
      if (call_.mesh->tet_to_vert.empty()) throw Error(ErrorCode::InputUnsuitable, "the mesh has no tetrahedra");
      check_transfer(*call_.mesh, options_.transfer);
      metric = metric_of_mesh();
      check_metric(metric, *call_.mesh);
      if (!is_alone()) fingerprint_ = fingerprint(*call_.mesh, metric, nullptr, options_, runner_);
    });
    if (!is_alone()) require_same(fingerprint_, work_);
    if (is_alone()) return start_whole(*call_.mesh, call_.mesh_given_up, std::move(metric));
    MeshSlice slice;
    work_.each([&] {
      slice = slice_of(*call_.mesh, metric, options_.transfer, work_.rank(), work_.rank_count());
      metric = MetricField();
      if (call_.mesh_given_up) *call_.mesh_given_up = Mesh();
    });
    start_slice(std::move(slice));
  }

  MetricField metric_of_mesh() const {
    if (call_.metric_given_up) return std::move(*call_.metric_given_up);
    return call_.metric ? *call_.metric : metric_from_function(call_.function, call_.mesh->points, runner_);
  }

  void start_from_parts() {
    const Mesh fields = fields_of(*call_.parts);
    work_.each([&] {
      check_transfer(fields, options_.transfer);
      if (call_.solution) check_solution(fields);
      fingerprint_ = fingerprint(fields, {}, call_.solution, options_, runner_);
    });
    require_same(fingerprint_, work_);
    PerPart<MetricField> metric = metric_of_parts();
    if (is_alone()) {
      gathered_ = gather_parts(std::move(*call_.parts), std::move(metric), work_);
      work_.each([&] {
        check_input(gathered_.mesh, gathered_.metric);
        if (call_.solution) gathered_.metric = metric_of_solution(gathered_.mesh);
      });
      return start_whole(gathered_.mesh, &gathered_.mesh, std::move(gathered_.metric));
    }
    std::vector<std::string> kept = options_.transfer;
    if (call_.solution) kept.push_back(call_.solution->field);
    MeshSlice slice = slice_of(std::move(*call_.parts), std::move(metric), kept, work_);
    work_.each([&] { check_input(slice.mesh, slice.metric); });
    if (call_.solution) take_metric_of_solution(slice);
    start_slice(std::move(slice));
  }

  void check_solution(const Mesh& fields) const {
    const std::string& name = call_.solution->field;
    const auto field = std::ranges::find(fields.point_fields, name, &MeshField::name);
    if (field == fields.point_fields.end())
      throw Error(ErrorCode::InputUnsuitable, "the mesh has no field \"" + name + "\" on its points");
    if (field->components != 1)
      throw Error(ErrorCode::InputUnsuitable, "the metric is made of a field of one component, and \"" + name +
                                                  "\" has " + std::to_string(field->components));
  }

  MetricField metric_of_solution(const Mesh& mesh) const {
    const auto& [name, options] = *call_.solution;
    const std::vector<double>& values = std::ranges::find(mesh.point_fields, name, &MeshField::name)->values;
    return metric_from_solution(values, {mesh.points, mesh.tet_to_vert}, options, runner_).metric;
  }

  void take_metric_of_solution(MeshSlice& slice) const {
    const auto& [name, options] = *call_.solution;
    slice.metric = metric_from_solution(slice, name, options, work_).metric;
    if (std::ranges::count(options_.transfer, name) == 0)
      std::erase_if(slice.mesh.point_fields, [&](const MeshField& field) { return field.name == name; });
    give_back_where_shared(work_.rank_count());
  }

  PerPart<MetricField> metric_of_parts() const {
    const PartitionedMesh& parts = *call_.parts;
    if (call_.parts_metric) {
      work_.each([&] { check_sizes(parts, *call_.parts_metric); });
      return std::move(*call_.parts_metric);
    }
    PerPart<MetricField> metric(parts.part_count(), parts.local());
    if (call_.solution) {  // of which none is known yet
      for (const PartId part : parts.local()) metric.at(part).logs.resize(parts.parts.at(part).mesh.vertex_count());
      return metric;
    }
    work_.each([&] {
      for (const PartId part : parts.local())
        metric.at(part) = metric_from_function(call_.function, parts.parts.at(part).mesh.points.span(), runner_);
    });
    return metric;
  }

  static void check_sizes(const PartitionedMesh& parts, const PerPart<MetricField>& metric) {
    if (metric.part_count() != parts.part_count())
      throw Error(ErrorCode::InvalidArgument, "the metric has " + std::to_string(metric.part_count()) + " parts for " +
                                                  std::to_string(parts.part_count()));
    for (const PartId part : parts.local())
      if (metric.at(part).size() != parts.parts.at(part).mesh.vertex_count())
        throw Error(ErrorCode::InvalidArgument,
                    "the metric has " + std::to_string(metric.at(part).size()) + " values for " +
                        std::to_string(parts.parts.at(part).mesh.vertex_count()) + " points of a part");
  }

  // Places in a slice mean nothing to others.
  void check_input(const Mesh& mesh, const MetricField& metric) const {
    try {
      check_mesh(mesh, runner_);
      check_metric(metric, mesh);
      check_transfer(mesh, options_.transfer);
    } catch (const Error& error) {
      Diagnostic diagnostic = error.diagnostic();
      diagnostic.elements.clear();
      throw Error(std::move(diagnostic));
    }
  }

  // On a single rank.
  void start_whole(const Mesh& mesh, Mesh* given_up, MetricField&& metric) {
    work_.each([&] {
      const TetView view{mesh.points, mesh.tet_to_vert};
      if (call_.function) return;
      if (options_.curvature) limit_by_curvature(metric, mesh, *options_.model, *options_.curvature, runner_);
      if (options_.gradation > 0)
        limit_gradation(metric, mesh.points, VertexGraph(view, runner_), options_.gradation, runner_);
      report_.turning = limit_turning(metric, view, runner_);
    });
    give_back_where_shared(work_.rank_count());
    work_.each([&] {
      report_.before = measure_conformity(mesh, metric, runner_);
      check_load(load_of(mesh.tet_to_vert.size(), mesh));
    });
    give_back_where_shared(work_.rank_count());
    work_.each([&] {
      if (split_touching(mesh, metric)) given_up = &refined_->mesh, metric = std::move(refined_->metric);
      AdapterInput input{refined_ ? refined_->mesh : mesh, given_up, std::move(metric)};
      adapter_.emplace(std::move(input), call_.function, options_, work_);
    });
  }

  // `fields`: of what is given, with or without values.
  AdaptLoad load_of(std::size_t tets, const Mesh& fields) const {
    double components = 0;
    for (const MeshField& field : fields.cell_fields)
      if (std::ranges::count(options_.transfer, field.name) != 0) components += field.components;
    return {report_.before.complexity, static_cast<double>(tets), components, work_.rank_count(),
            work_.ranks().ranks_on_machine()};
  }

  // The mesh without edges at which it touches itself, and the metric there; nothing where it has none.
  bool split_touching(const Mesh& mesh, const MetricField& metric) {
    constexpr double kMostOfTouching = 2;  // times the tets that the metric asks for
    const double most =
        static_cast<double>(mesh.tet_to_vert.size()) + kMostOfTouching * expected_tets(report_.before.complexity);
    refined_ = split_touching_edges(mesh, metric, call_.function, options_.model, static_cast<std::size_t>(most));
    // Errors name elements of the mesh that was given.
    if (refined_) make_whole_mesh(mesh, runner_);
    return refined_.has_value();
  }

  void start_slice(MeshSlice&& slice) {
    if (!call_.function) limit(slice);
    report_.before = conformity_of(slice, work_);
    work_.each([&] { check_load(load_of(slice.tet_count(), slice.mesh)); });
    give_back_where_shared(work_.rank_count());
    if (touches_itself(slice)) split_together(slice);
    adapter_.emplace(share_of(std::move(slice), call_.function, options_, work_), call_.function, options_, work_);
  }

  void limit(MeshSlice& slice) {
    const TetView view = tets_of(slice.mesh);
    if (options_.curvature) limit_by_curvature(slice, *options_.model, *options_.curvature, work_);
    if (options_.gradation > 0) limit_gradation(slice, options_.gradation, work_);
    report_.turning = limit_turning(slice.metric, view, slice.own_tets(work_), runner_);
    give_back_where_shared(work_.rank_count());
  }

  bool touches_itself(const MeshSlice& slice) const {
    std::array<double, 1> touches{0};
    work_.each([&] { touches[0] = has_touching_edges(slice.mesh, slice.is_own) ? 1 : 0; });
    work_.max(touches);
    return touches[0] > 0;
  }

  // The longest edge of all is split first, so every rank does it all.
  void split_together(MeshSlice& slice) {
    MeshWithMetric whole = gather_slices(slice, work_);
    work_.each([&] {
      if (!split_touching(whole.mesh, whole.metric)) return;
      whole = MeshWithMetric();
      slice = slice_of(refined_->mesh, refined_->metric, options_.transfer, work_.rank(), work_.rank_count());
      refined_.reset();
    });
  }

  const AdaptCall& call_;
  const AdaptOptions& options_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  AdaptReport& report_;
  std::uint64_t fingerprint_ = 0;
  MeshWithMetric gathered_;
  std::optional<RefinedInput> refined_;
  std::optional<Adapter> adapter_;
};

}  // namespace

void adapt_together(const AdaptCall& call, const SharedWork& work, AdaptReport& report,
                    const std::function<void(Adapter&)>& finish) {
  Stopwatch watch;
  Start start(call, work, report);
  Adapter& adapter = start.run();
  report.stages.set_up = watch.lap();
  adapter.run(report);
  watch.lap();
  finish(adapter);
  report.stages.result += watch.lap();
}

}  // namespace tetloom::adapt
