#include "apps/tetloom/model_reading.hpp"

#include <chrono>

#include "apps/tetloom/ranks.hpp"

namespace tetloom::app {

ModelReading::ModelReading(const MeshCommand& command) : command_(command) {
  if (!is_one_of_several()) return;
  begun_ = std::async(std::launch::async, [this] { return read_model(command_.input, command_.read, &stop_); });
}

ModelReading::~ModelReading() { stop_.cancel(); }

ModelDocument ModelReading::take(const CancelToken& cancel) {
  if (!begun_.valid()) return read_model(command_.input, command_.read, &cancel);
  constexpr auto kPatience = std::chrono::milliseconds(20);
  while (begun_.wait_for(kPatience) != std::future_status::ready)
    if (cancel.cancelled()) stop_.cancel();
  return begun_.get();
}

}  // namespace tetloom::app
