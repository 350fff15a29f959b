#include "apps/tetloom/parts_input.hpp"
#include "tetloom/tasks.hpp"

#include "apps/tetloom/parts_text.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::app {

std::optional<WholeOfParts> read_whole_of_parts(const std::filesystem::path& input, Communicator& communicator,
                                                const TaskRunner& runner, Run& run) {
  if (!is_partitioned_file(input, communicator)) return std::nullopt;
  run.begin_together(Stage::Read);
  WholeOfParts whole;
  RunReport& report = run.report();
  report.seconds.read = timed([&] {
    auto [mesh, misfit] =
        read_input([&] { return read_parts_as_they_are(input, communicator, runner, &run.cancel()); });
    whole.misfit = std::move(misfit);
    whole.figures = measure_parts(mesh);
    report.parts = static_cast<int>(mesh.part_count());
    report.extra["partition"] = parts_json(whole.figures);
    if (!whole.misfit) whole.mesh = gather_mesh(mesh, runner);
  });
  return whole;
}

}  // namespace tetloom::app
