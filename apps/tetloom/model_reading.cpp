#include "apps/tetloom/model_reading.hpp"

#include <chrono>

#include "apps/tetloom/ranks.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::app {
ModelDocument read(const std::filesystem::path& path, const ReadOptions& options, int threads,
                   const CancelToken& cancel) {
  const TaskRunner runner(threads, {{}, &cancel});
  return read_model(path, options, &cancel, runner);
}

ModelDocument read_on_ranks(const std::filesystem::path& path, const ReadOptions& options, int threads,
                            const CancelToken& cancel, Communicator& communicator) {
  const TaskRunner runner = TaskRunner(threads, {{}, &cancel}).with_idle_threads(communicator.ranks_on_machine());
  return read_model_on_ranks([&] { return read_model(path, options, &cancel, runner); }, communicator, runner);
}

ModelReading::ModelReading(const MeshCommand& command) : command_(command) {
  if (!is_one_of_several() || !is_first_process()) return;
  begun_ = std::async(std::launch::async,
                      [this] { return read(command_.input, command_.read, command_.options.threads, stop_); });
}

ModelReading::~ModelReading() { stop_.cancel(); }

ModelDocument ModelReading::take(const CancelToken& cancel, Communicator& communicator) {
  const TaskRunner runner =
      TaskRunner(command_.options.threads, {{}, &cancel}).with_idle_threads(communicator.ranks_on_machine());
  return read_model_on_ranks([&] { return take_own(cancel); }, communicator, runner);
}

ModelDocument ModelReading::take_own(const CancelToken& cancel) {
  if (!begun_.valid()) return read(command_.input, command_.read, command_.options.threads, cancel);
  constexpr auto kPatience = std::chrono::milliseconds(20);
  while (begun_.wait_for(kPatience) != std::future_status::ready)
    if (cancel.cancelled()) stop_.cancel();
  return begun_.get();
}

}  // namespace tetloom::app
