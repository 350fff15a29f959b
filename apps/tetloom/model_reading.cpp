#include "apps/tetloom/model_reading.hpp"

#include <chrono>
#include <functional>
#include <string>

#include "apps/tetloom/option_values.hpp"
#include "apps/tetloom/ranks.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::app {
namespace {

// Models of facets cannot be stored: all ranks read them, and at the same time.
bool is_for_all(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".stl" || extension == ".obj";
}

ModelDocument for_ranks(const std::filesystem::path& path, const std::function<ModelDocument()>& read,
                        Communicator& communicator, const BlockLoop& loop) {
  if (!is_for_all(path)) return read_model_on_ranks(read, communicator, loop);
  ModelDocument document;
  run_on_all(communicator, [&] { document = read(); });
  return document;
}

}  // namespace

ModelDocument read(const std::filesystem::path& path, const ReadOptions& options, int threads,
                   const CancelToken& cancel) {
  const TaskRunner runner(threads, {{}, &cancel});
  return read_model(path, options, &cancel, runner);
}

ModelDocument read_on_ranks(const std::filesystem::path& path, const ReadOptions& options, int threads,
                            const CancelToken& cancel, Communicator& communicator) {
  const TaskRunner runner = TaskRunner(threads, {{}, &cancel}).with_idle_threads(communicator.ranks_on_machine());
  return for_ranks(
      path, [&] { return read_model(path, options, &cancel, runner); }, communicator, runner);
}

ModelReading::ModelReading(const MeshCommand& command) : command_(command) {
  if (!is_one_of_several() || !(is_first_process() || is_for_all(command.input))) return;
  begun_ = std::async(std::launch::async,
                      [this] { return read(command_.input, command_.read, command_.options.threads, stop_); });
}

ModelReading::~ModelReading() { stop_.cancel(); }

ModelDocument ModelReading::take(const CancelToken& cancel, Communicator& communicator) {
  const TaskRunner runner =
      TaskRunner(command_.options.threads, {{}, &cancel}).with_idle_threads(communicator.ranks_on_machine());
  return for_ranks(
      command_.input, [&] { return take_own(cancel); }, communicator, runner);
}

ModelDocument ModelReading::take_own(const CancelToken& cancel) {
  if (!begun_.valid()) return read(command_.input, command_.read, command_.options.threads, cancel);
  constexpr auto kPatience = std::chrono::milliseconds(20);
  while (begun_.wait_for(kPatience) != std::future_status::ready)
    if (cancel.cancelled()) stop_.cancel();
  return begun_.get();
}

}  // namespace tetloom::app
