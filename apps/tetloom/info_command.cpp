#include "apps/tetloom/commands.hpp"
#include "apps/tetloom/mesh_text.hpp"
#include "apps/tetloom/model_text.hpp"
#include "apps/tetloom/parts_input.hpp"
#include "apps/tetloom/parts_text.hpp"
#include "apps/tetloom/run.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::app {
namespace {

/// STL files are both; as a model they say more.
bool is_mesh_file(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return is_mesh_extension(path) && extension != ".stl";
}

/// `parts_text` describes the parts, where the mesh has some.
void describe_whole(const Mesh& mesh, const std::string& parts_text, const TaskRunner& runner, Run& run) {
  RunReport& report = run.report();
  run.begin(Stage::Check);
  report.seconds.check = timed([&] {
    report.quality = compute_quality(mesh, nullptr, runner);
    report.digest = mesh_digest(mesh, runner);
  });
  report.counts = {mesh.points.size(), mesh.tri_to_vert.size(), mesh.tet_to_vert.size(),
                   report.quality->cells.regions.size()};
  report.entities = mesh.entities;
  report.extra["mesh"] = mesh_json(mesh, report);
  run.set_text(render_mesh(mesh, report) + parts_text);
}

void describe_mesh(const InfoCommand& command, const TaskRunner& runner, Run& run) {
  Mesh mesh;
  run.report().seconds.read =
      timed([&] { mesh = read_input([&] { return read_mesh(command.input, &run.cancel()); }); });
  describe_whole(mesh, {}, runner, run);
}

void describe_model(const InfoCommand& command, const TaskRunner& runner, Run& run) {
  RunReport& report = run.report();
  ModelDocument document;
  report.seconds.read = timed(
      [&] { document = read_input([&] { return read_model(command.input, command.read, &run.cancel(), runner); }); });
  run.begin(Stage::Check);
  report.warnings = document.warnings;
  report.counts.regions = document.model->topology().region_count();
  report.extra["model"] = model_json(document);
  run.set_text(render_model(document, command.input.string()));
}

}  // namespace

ExitStatus run_info(const InfoCommand& command, Communicator& communicator) {
  Run run({.input = command.input,
           .output = {},
           .report = command.report,
           .quiet = command.quiet,
           .threads = TaskRunner(command.threads).threads(),
           .ranks = &communicator});
  return run.execute([&](Run& r) {
    const TaskRunner runner(command.threads, r.host());
    if (const std::optional<WholeOfParts> whole = read_whole_of_parts(command.input, r.ranks(), runner, r)) {
      if (whole->misfit) throw Error(*whole->misfit);
      return run_on_first(r.ranks(), [&] { describe_whole(whole->mesh, render_parts(whole->figures), runner, r); });
    }
    run_on_first(r.ranks(), [&] {
      r.begin(Stage::Read);
      is_mesh_file(command.input) ? describe_mesh(command, runner, r) : describe_model(command, runner, r);
    });
  });
}

}  // namespace tetloom::app
