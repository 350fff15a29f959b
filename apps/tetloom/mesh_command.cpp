#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <span>

#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/console.hpp"
#include "apps/tetloom/entity_sizes.hpp"
#include "apps/tetloom/mesh_report.hpp"
#include "apps/tetloom/model_reading.hpp"
#include "apps/tetloom/parts_text.hpp"
#include "apps/tetloom/parts_whole.hpp"
#include "apps/tetloom/rank_figures.hpp"
#include "apps/tetloom/run.hpp"
#include "apps/tetloom/solid_copies.hpp"
#include "core/base/free_memory.hpp"
#include "tetloom/io.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/group_names.hpp"

namespace tetloom::app {
namespace {

struct Sized {
  ModelDocument document;
  MeshOptions options;
  std::vector<GroupMember> groups;
};

// The sizes asked for hold on the faces of the given model. From there they grow, up to a share of the box's diagonal.
void put_in_far_field(double factor, ModelDocument& document, SizeOptions& sizes) {
  constexpr double kDefaultSize = 1.0 / 40, kFarSize = 1.0 / 20, kFloor = 0.1;
  const double diagonal = document.model->bounding_box().diagonal();
  const double share = sizes.relative_size > 0 ? sizes.relative_size : kDefaultSize;
  const double size = sizes.size > 0 ? sizes.size : diagonal * share;
  document.model = put_into_box(std::move(document.model), factor);
  const std::size_t box_faces = 6, faces = document.model->topology().face_count();
  for (std::size_t f = 0; f + box_faces < faces; ++f) sizes.entity_sizes.push_back({ModelFaceId(f), size});
  if (sizes.min_size == 0) sizes.min_size = kFloor * size;
  sizes.size = std::max(size, kFarSize * document.model->bounding_box().diagonal());
  sizes.relative_size = 0;
}

// A model with the sizes asked for its entities.
Sized with_sizes(const MeshCommand& command, ModelDocument document, Run& run) {
  RunReport& report = run.report();
  SizesFile sizes;
  if (!command.sizes_file.empty()) sizes = read_sizes(command.sizes_file);
  std::vector<GroupWish> groups = command.groups;
  if (!command.groups_file.empty()) std::ranges::copy(read_groups(command.groups_file), std::back_inserter(groups));
  Sized sized{std::move(document), command.options, {}};
  report.warnings = sized.document.warnings;
  if (command.far_field > 0) put_in_far_field(command.far_field, sized.document, sized.options.sizes);
  apply_sizes(sizes, *sized.document.model, sized.options.sizes);
  sized.groups = find_members(groups, *sized.document.model);
  sized.options.layers = find_wall_layers(command.layers, *sized.document.model);
  return sized;
}

void check(const MeshResult& result, const TaskRunner& runner, Run& run) {
  RunReport& report = run.report();
  if (report.status == ExitStatus::Cancelled) return;
  run.begin(Stage::Check);
  report.seconds.check = timed([&] { measure_mesh(result.mesh, result.sizes, runner, report); });
}

using SolidLists = std::vector<std::vector<ModelRegionId>>;

// The model of the file with solids made anew, for the ranks of a run that hold the shapes they need: the first one
// reads the file again. None where the last of the solids cannot be made anew.
std::optional<ModelDocument> rebuild_stored(const MeshCommand& command, SolidLists lists, Communicator& communicator,
                                            const CancelToken& cancel) {
  std::uint64_t is_rebuilt = 0;
  const TaskRunner runner(command.options.threads, {{}, &cancel});
  const std::vector<ModelRegionId> last = std::move(lists.back());
  lists.pop_back();
  ReadOptions options = command.read;
  options.rebuilt = std::move(lists);
  ModelDocument document = read_model_on_ranks(
      [&] {
        ModelDocument given = read_model(command.input, options, &cancel, runner);
        std::optional<ModelDocument> rebuilt = rebuild_solids(given, last, &cancel, runner);
        is_rebuilt = rebuilt.has_value();
        return rebuilt ? std::move(*rebuilt) : std::move(given);
      },
      communicator, runner);
  if (share_number(communicator, is_rebuilt) == 0) return {};
  return document;
}

// Makes the last of the solids anew from the space that they enclose. False where that cannot be done, and nothing has
// changed then.
bool repair(const MeshCommand& command, const SolidLists& lists, Sized& sized, Communicator& communicator, Run& run) {
  std::optional<ModelDocument> rebuilt;
  run.begin_together(Stage::Read);
  run.report().seconds.read += timed([&] {
    if (sized.document.model->shape_memory()) {
      rebuilt = rebuild_stored(command, lists, communicator, run.cancel());
      return;
    }
    const TaskRunner runner(command.options.threads, {{}, &run.cancel()});
    run_on_all(communicator, [&] { rebuilt = rebuild_solids(sized.document, lists.back(), &run.cancel(), runner); });
  });
  if (!rebuilt) return false;
  run_on_all(communicator, [&] { sized = with_sizes(command, std::move(*rebuilt), run); });
  note_rebuilt(lists, run.report());
  return true;
}

void add(const StageSeconds& more, StageSeconds& seconds) {
  seconds.size_field += more.size_field;
  seconds.surface += more.surface;
  seconds.layers += more.layers;
  seconds.volume += more.volume;
  seconds.second_order += more.second_order;
}

// Solids whose boundary crosses itself are made anew, and the model is meshed again; the seconds are those of all
// attempts, which end early where it is sure that solids cross. The next one may find that others cross as well, but a
// solid is made anew only once.
MeshResult make_or_repair(const MeshCommand& command, Sized& sized, Communicator& communicator, Run& run) {
  constexpr int kMostRepairs = 2;
  StageSeconds seconds;
  std::vector<ModelRegionId> repaired;
  SolidLists lists = command.read.rebuilt;
  if (!lists.empty()) note_rebuilt(lists, run.report());
  bool may_repair = command.read.heal && command.far_field == 0;
  for (int attempt = 0;; ++attempt) {
    MeshOptions options = sized.options;
    options.stop_where_model_crosses = may_repair;
    MeshResult result = make_mesh_on_ranks(*sized.document.model, options, communicator, run.host());
    add(result.seconds, seconds);
    result.seconds = seconds;
    may_repair = may_repair && attempt < kMostRepairs && result.status != MeshStatus::Cancelled;
    const ModelTopology& topology = sized.document.model->topology();
    std::vector<ModelRegionId> crossing;
    if (may_repair) crossing = regions_that_cross(result, topology);
    const bool is_again =
        std::ranges::any_of(crossing, [&](ModelRegionId r) { return std::ranges::count(repaired, r) > 0; });
    if (!crossing.empty()) crossing = with_copies(crossing, *sized.document.model);
    const std::size_t regions = topology.region_count();
    lists.push_back(crossing);
    const bool is_repaired = !crossing.empty() && !is_again && repair(command, lists, sized, communicator, run);
    if (!is_repaired && !result.stopped_early) return result;
    if (!is_repaired) lists.pop_back();
    repaired.insert(repaired.end(), crossing.begin(), crossing.end());
    // Solids in several pieces change the numbers of the others.
    may_repair = is_repaired && sized.document.model->topology().region_count() == regions;
  }
}

void note_groups(const std::vector<GroupMember>& members, RunReport& report) {
  nlohmann::ordered_json groups = nlohmann::ordered_json::object();
  for (const auto& [entity, group] : members) {
    groups[group]["dim"] = entity.dim;
    groups[group]["ids"].push_back(entity.tag());
  }
  if (!members.empty()) report.extra["groups"] = std::move(groups);
}

// What the lengths of the model are multiplied by for the output.
double scale_of(const MeshCommand& command, const GeometricModel& model) {
  if (command.metres_per_unit == 0) return 1;
  if (model.metres_per_unit() == 0)
    throw Error(ErrorCode::InvalidArgument,
                "--unit cannot scale '" + command.input.string() + "': the file does not say the unit of its lengths");
  return model.metres_per_unit() / command.metres_per_unit;
}

void note_scale(const MeshCommand& command, double scale, RunReport& report) {
  if (scale != 1) report.extra["unit"] = {{"metres", command.metres_per_unit}, {"scale", scale}};
}

// A text for each name; a list where the entities of one name have several in the file.
void note_names(const std::vector<NamedGroup>& groups, RunReport& report) {
  std::map<std::string, std::vector<std::string>> by_name;
  for (const NamedGroup& group : groups) {
    if (group.original.empty()) continue;
    std::vector<std::string>& known = by_name[group.original];
    if (std::ranges::count(known, group.sanitised) == 0) known.push_back(group.sanitised);
  }
  nlohmann::ordered_json names = nlohmann::ordered_json::object();
  for (const auto& [original, sanitised] : by_name)
    sanitised.size() == 1 ? names.emplace(original, sanitised[0]) : names.emplace(original, sanitised);
  report.extra["names"] = std::move(names);
}

void write(const MeshCommand& command, double scale, Mesh& mesh, const TaskRunner& runner, Run& run) {
  if (scale != 1)
    for (Vec3& x : mesh.points) x = scale * x;
  note_scale(command, scale, run.report());
  if (holds_solver_names(command.output, command.write)) note_names(solver_names(mesh), run.report());
  write_mesh(mesh, command.output, command.write, &run.cancel(), runner);
}

void write_in_parts(const MeshCommand& command, double scale, PartitionedMesh& mesh, const TaskRunner& runner,
                    Run& run) {
  if (scale != 1)
    for (const PartId part : mesh.local())
      for (Vec3& x : mesh.parts.at(part).mesh.points) x = scale * x;
  note_scale(command, scale, run.report());
  if (holds_solver_names(command.output, command.write)) {
    const detail::GroupNames names = detail::gather_group_names(mesh);
    note_names(detail::list_names(names.groups, names.entities), run.report());
  }
  write_parts(mesh, command.output, runner, &run.cancel());
}

// The first rank has the whole mesh, and the threads of those that wait for it.
void mesh_model(const MeshCommand& command, Sized& sized, Communicator& communicator, Run& run) {
  const auto& [document, options, groups] = sized;
  RunReport& report = run.report();
  const double scale = scale_of(command, *document.model);
  MeshResult result = make_or_repair(command, sized, communicator, run);
  note_run(result, *document.model, options, report);
  run_on_first(communicator, [&] {
    if (!result.mesh.tet_to_vert.empty()) note_filling(result.filling, options.goals, report);
    const TaskRunner runner =
        TaskRunner(options.threads, run.host()).with_idle_threads(communicator.ranks_on_machine());
    check(result, runner, run);
    if (result.status != MeshStatus::Ok && !result.is_partial) return;

    apply_groups(groups, *document.model, result.mesh.entities);
    note_groups(groups, report);
    run.begin(Stage::Write);
    report.seconds.write = timed([&] { write(command, scale, result.mesh, runner, run); });
    run.set_text(render_summary(report, command.output.string(), command.report.string()));
  });
  note_ranks(communicator, result.mesh.tet_to_vert.size(), document.model.get(), report);
}

void mesh_model_in_parts(const MeshCommand& command, const Sized& sized, Communicator& communicator, Run& run) {
  const auto& [document, options, groups] = sized;
  RunReport& report = run.report();
  const double scale = scale_of(command, *document.model);
  MeshInPartsResult result = make_mesh_in_parts(*document.model, options, communicator, run.host());
  note_run(result.run, *document.model, options, report);
  const TaskRunner runner(options.threads, run.host());
  if (!result.mesh) return run_on_first(communicator, [&] { check(result.run, runner, run); });

  result.run.mesh = Mesh();
  note_filling(result.run.filling, options.goals, report);
  run.begin_together(Stage::Check);
  PartsFigures figures;
  report.parts = static_cast<int>(result.mesh->part_count());
  report.seconds.check = timed([&] {
    figures = measure_parts(*result.mesh);
    note_summary(summarize_parts(*result.mesh, runner, &result.run.sizes), figures, report);
  });
  report.extra["partition"] = parts_json(figures);
  report.extra["partition"]["seconds"] = result.partition_seconds;
  note_model_bytes(*result.mesh, *document.model, report.extra["partition"]);

  for (const PartId part : result.mesh->local()) apply_groups(groups, result.mesh->parts.at(part).mesh.entities);
  note_groups(groups, report);
  run.begin_together(Stage::Write);
  report.seconds.write = timed([&] { write_in_parts(command, scale, *result.mesh, runner, run); });
  run.set_text(render_summary(report, command.output.string(), command.report.string()) + render_parts(figures));
  note_ranks(communicator, tets_of_rank(*result.mesh), document.model.get(), report);
}

void mesh_input(const MeshCommand& command, ModelReading& reading, Communicator& communicator, Run& run) {
  if (communicator.rank_count() > 1) return_freed_memory();
  Sized sized;
  ModelDocument document;
  run.begin_together(Stage::Read);
  run.report().seconds.read +=
      timed([&] { document = read_input([&] { return reading.take(run.cancel(), communicator); }); });
  run_on_all(communicator, [&] { sized = with_sizes(command, std::move(document), run); });
  command.in_parts ? mesh_model_in_parts(command, sized, communicator, run)
                   : mesh_model(command, sized, communicator, run);
}

}  // namespace

ExitStatus run_mesh(const MeshCommand& command, ModelReading& reading, Communicator& communicator) {
  Run run({.input = command.input,
           .output = command.output,
           .report = command.report,
           .quiet = command.quiet,
           .threads = TaskRunner(command.options.threads).threads(),
           .parts = std::max(1, command.options.parts),
           .ranks = &communicator});
  return run.execute([&](Run& r) { mesh_input(command, reading, r.ranks(), r); });
}

}  // namespace tetloom::app
