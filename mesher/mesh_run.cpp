#include "mesher/mesh_run_detail.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>

#include "core/base/failure.hpp"
#include "core/base/free_memory.hpp"
#include "core/base/stage_clock.hpp"
#include "core/base/stopwatch.hpp"
#include "mesher/check_solids.hpp"
#include "mesher/failed_complexes.hpp"
#include "mesher/fit_surface.hpp"
#include "mesher/layers/grow_layers.hpp"
#include "mesher/layers/layer_memory.hpp"
#include "mesher/layers/layered_mesh.hpp"
#include "mesher/second_order/make_second_order.hpp"
#include "mesher/sizing/model_facets.hpp"
#include "mesher/surface/drop_faces.hpp"
#include "mesher/surface_input.hpp"
#include "mesher/tets/quality_goals.hpp"
#include "mesher/volume/angle_causes.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/copy_of_machine.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {
namespace {

class MeshRun {
 public:
  MeshRun(const GeometricModel& model, const MeshOptions& options, const Host& host, const VolumeUse& use,
          Communicator* ranks)
      : model_(model),
        options_(options),
        work_(options.threads, host, ranks),
        runner_(work_.runner()),
        use_(use),
        on_several_ranks_(ranks && ranks->rank_count() > 1) {}

  MeshResult run() {
    const std::optional<Diagnostic> failure = failure_of([&] { work_.together([&] { run_stages(); }); });
    if (failure && failure->code == ErrorCode::InvalidArgument) throw Error(*failure);
    if (failure) fail(*failure);
    return std::move(result_);
  }

 private:
  void fail(const Diagnostic& diagnostic) {
    result_.status = diagnostic.code == ErrorCode::Cancelled ? MeshStatus::Cancelled : MeshStatus::Failed;
    result_.errors.push_back(diagnostic);
  }

  void run_stages() {
    const bool fills = !options_.surface_only && model_.topology().region_count() > 0;
    measure_model();
    if (!SurfaceFitter(model_, options_, work_, failed_, result_).run()) return;
    give_back_where_shared(work_.rank_count());
    if (fills) check_solids();
    if (fills && !mesh_volume()) return;
    if (options_.order == 2) make_second_order(fills);
    result_.status = MeshStatus::Ok;
    if (!failed_.empty()) finish_partial();
  }

  void finish_partial() {
    result_.status = MeshStatus::Failed;
    result_.is_partial = true;
    append(failed_.errors(), {});
    const std::vector<bool> missing = failed_.faces();
    const auto& region_to_faces = model_.topology().region_to_faces;
    for (std::size_t r = 0; r < region_to_faces.size(); ++r)
      if (!region_to_faces[r].empty() && missing[region_to_faces[r].front().value])
        result_.model_volume -= model_.volume(ModelRegionId(r));
  }

  // The model keeps what it has measured, and sizes ask for areas first. Solids of spline faces are dearest.
  void measure_model() {
    Stopwatch watch;
    runner_.begin_stage(Stage::SizeField, 0);
    const ModelTopology& topology = model_.topology();
    const std::size_t regions = topology.region_count();
    std::vector<double>& volumes = model_volumes_;
    volumes.resize(regions);
    runner_.for_each(regions + topology.face_count(), [&](std::size_t i) {
      if (i < regions) {
        volumes[i] = model_.volume(ModelRegionId(i));
      } else {
        tolerate_bad_geometry([&] { model_.area(ModelFaceId(i - regions)); });
      }
    });
    result_.model_volume = std::accumulate(volumes.begin(), volumes.end(), 0.0);
    result_.seconds.size_field += watch.lap();
  }

  void append(const std::vector<Diagnostic>& errors, const std::vector<Diagnostic>& warnings) {
    result_.errors.insert(result_.errors.end(), errors.begin(), errors.end());
    result_.warnings.insert(result_.warnings.end(), warnings.begin(), warnings.end());
  }

  void check_solids() {
    Stopwatch watch;
    const MeshedModel meshed{model_, result_.mesh, result_.sizes};
    std::vector<Diagnostic> warnings = check_volumes(meshed, model_volumes_);
    // With mid nodes volumes will be other ones.
    if (options_.order == 2) std::erase_if(warnings, differs_in_volume);
    append({}, warnings);
    append({}, check_overlaps(meshed, runner_));
    result_.seconds.volume += watch.lap();
  }

  // What one rank cannot fill no other one knows of before the end, so ranks give up together.
  bool mesh_volume() {
    for (;;) {
      std::vector<Diagnostic> errors = options_.layers.walls.empty() ? fill_volume() : fill_above_layers();
      if (errors.empty()) return true;
      const bool others = options_.keep_going && !on_several_ranks_ && !runner_.cancelled() && failed_.take(errors);
      if (!others) {
        append(errors, {});
        result_.status = MeshStatus::Failed;
        return false;
      }
      drop_faces(failed_.faces(), result_.mesh);
    }
  }

  std::vector<Diagnostic> fill_volume() {
    Stopwatch watch;
    VolumeParts volume = [&] {
      const SurfaceInput surface(result_.mesh, model_.topology(), copy_of_machine(work_.ranks()));
      return fill(surface.input(model_, result_.sizes), options_.goals);
    }();
    note(volume);
    std::vector<Diagnostic> errors = std::move(volume.errors);
    if (errors.empty()) use_.take(std::move(volume), result_.mesh, work_);
    result_.seconds.volume += watch.lap();
    return errors;
  }

  VolumeParts fill(const VolumeInput& input, const QualityGoals& goals) {
    const VolumeOptions options{options_.volume_worker,
                                options_.worker_only,
                                options_.improve_surface,
                                options_.max_memory,
                                goals,
                                options_.lattice,
                                options_.tets_per_part,
                                options_.trace};
    return tetloom::fill_volume(input, options, work_);
  }

  // Where the surface has to stay, the inside gets the rounds that the surface would have had.
  QualityGoals goals_above_layers() const {
    constexpr int kRoundsOfSurface = 4;
    QualityGoals goals = options_.goals;
    goals.rounds = std::min(100, kRoundsOfSurface * goals.rounds);
    return goals;
  }

  void note(VolumeParts& volume) {
    append({}, volume.warnings);
    if (const auto flat = volume::warn_of_flat_tets(volume.figures.optimizer)) append({}, {*flat});
    result_.filling = std::move(volume.figures);
  }

  // Where a region cannot be filled above its layers it gets fewer, and none in the end.
  std::vector<Diagnostic> fill_above_layers() {
    Stopwatch watch;
    runner_.begin_stage(Stage::Layers, 0);
    layers::check_layer_memory(model_, result_.mesh, options_.layers, options_.max_memory);
    layers::LayerGrowth growth(model_, result_.mesh, result_.sizes, options_.layers, runner_);
    result_.seconds.layers += watch.lap();
    std::vector<Diagnostic> errors;
    for (const double share : {0.5, 0.0, 0.0}) {
      VolumeParts volume = fill(growth.surface().input(model_, result_.sizes), goals_above_layers());
      result_.seconds.volume += watch.lap();
      errors = std::move(volume.errors);
      if (errors.empty()) {
        finish_layers(growth, std::move(volume));
        break;
      }
      if (!growth.lower(regions_of(errors), share)) break;
      result_.seconds.layers += watch.lap();
    }
    return errors;
  }

  void finish_layers(const layers::LayerGrowth& growth, VolumeParts&& volume) {
    Stopwatch watch;
    note(volume);
    result_.layers = layers::measure_layers(growth, result_.mesh, runner_);
    result_.seconds.layers += watch.lap();
    const double seconds = use_.take_above_layers(std::move(volume), growth, result_.mesh, work_);
    result_.seconds.volume += watch.lap() - seconds;
    result_.seconds.layers += seconds;
    result_.layers.seconds = result_.seconds.layers;
  }

  // Those on the sides of the faces that errors name, and those that they name themselves.
  std::vector<std::uint32_t> regions_of(const std::vector<Diagnostic>& errors) const {
    std::vector<std::uint32_t> regions;
    for (const Diagnostic& error : errors)
      for (const NamedEntity& named : error.entities) {
        if (named.entity.dim == 3) regions.push_back(named.entity.index);
        if (named.entity.dim != 2) continue;
        const FaceSides& sides = model_.topology().face_to_sides[named.entity.index];
        for (const ModelRegionId region : {sides.front, sides.back})
          if (region.valid()) regions.push_back(region.value);
      }
    return regions;
  }

  static bool differs_in_volume(const Diagnostic& warning) { return warning.code == ErrorCode::VolumeDiffers; }

  // The first rank has the mesh.
  void make_second_order(bool fills) {
    if (work_.rank() > 0) return;
    Stopwatch watch;
    result_.second_order =
        second_order::make_second_order(model_, options_.min_scaled_jacobian, result_.mesh, work_.runner_for_one());
    if (fills) {
      std::vector<Diagnostic> warnings = check_volumes({model_, result_.mesh, result_.sizes}, model_volumes_);
      std::erase_if(warnings, std::not_fn(differs_in_volume));
      append({}, warnings);
    }
    result_.seconds.second_order = watch.lap();
  }

  const GeometricModel& model_;
  const MeshOptions& options_;
  const SharedWork work_;
  const TaskRunner& runner_;
  const VolumeUse& use_;
  const bool on_several_ranks_;
  MeshResult result_;
  std::vector<double> model_volumes_;  // per region
  FailedComplexes failed_{model_};
};

Host with_clock(const Host& host, StageClock& clock) {
  Host timed = host;
  timed.progress = [&clock, progress = host.progress](const ProgressEvent& event) {
    clock.enter(event.stage);
    return !progress || progress(event);
  };
  return timed;
}

// A stage that was left by an exception has not been counted.
void count_unfinished_stage(const StageClock& clock, StageSeconds& seconds) {
  seconds.size_field = std::max(seconds.size_field, clock.seconds(Stage::SizeField));
  seconds.surface = std::max(
      seconds.surface, clock.seconds(Stage::Edges) + clock.seconds(Stage::Faces) + clock.seconds(Stage::Intersections));
  seconds.layers = std::max(seconds.layers, clock.seconds(Stage::Layers));
  seconds.volume = std::max(seconds.volume, clock.seconds(Stage::Volume));
  seconds.second_order = std::max(seconds.second_order, clock.seconds(Stage::SecondOrder));
}

}  // namespace

MeshResult run_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host, const VolumeUse& use,
                    Communicator* ranks) {
  check_goals(options.goals);
  if (options.parts < 0) throw Error(ErrorCode::InvalidArgument, "the number of parts must not be negative");
  if (!(options.tets_per_part >= 0))
    throw Error(ErrorCode::InvalidArgument, "the tets of a part must not be fewer than none");
  if (!(options.small_feature >= 0 && std::isfinite(options.small_feature)))
    throw Error(ErrorCode::InvalidArgument, "small_feature must be positive and finite (or 0 to leave it unset)");
  if (options.order != 1 && options.order != 2) throw Error(ErrorCode::InvalidArgument, "the order must be 1 or 2");
  if (!(options.min_scaled_jacobian >= 0 && options.min_scaled_jacobian <= 0.9))
    throw Error(ErrorCode::InvalidArgument, "min_scaled_jacobian must lie between 0 and .9");
  layers::check_layer_options(model, options.layers);
  if (!options.layers.walls.empty() && options.layers.all_tets && options.order == 2)
    throw Error(ErrorCode::InvalidArgument, "layers of tets alone are of first order");
  if (!options.layers.walls.empty() && options.surface_only)
    throw Error(ErrorCode::InvalidArgument, "layers need a volume");
  if (!(options.most_refinement >= 1)) throw Error(ErrorCode::InvalidArgument, "most_refinement must be at least 1");
  StageClock clock;
  MeshResult result = MeshRun(model, options, with_clock(host, clock), use, ranks).run();
  if (result.status != MeshStatus::Ok) count_unfinished_stage(clock, result.seconds);
  return result;
}

}  // namespace tetloom
