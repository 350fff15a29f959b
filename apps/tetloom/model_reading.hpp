#pragma once
// The model of a run, read while its ranks find each other.
#include <future>

#include "apps/tetloom/options.hpp"
#include "tetloom/host.hpp"
#include "tetloom/model.hpp"

namespace tetloom::app {

/// Reads a model on `threads` threads; 0: on all cores. Errors: as read_model.
ModelDocument read(const std::filesystem::path& path, const ReadOptions& options, int threads,
                   const CancelToken& cancel);

/// Starting MPI takes about as long as reading a small model, and it mostly waits: where several ranks were started
/// together, each begins to read at once, in a thread of its own.
class ModelReading {
 public:
  explicit ModelReading(const MeshCommand& command);
  /// Ends a reading that nobody waits for.
  ~ModelReading();
  ModelReading(const ModelReading&) = delete;
  ModelReading& operator=(const ModelReading&) = delete;

  /// The model; read here and now where that has not begun before. To be called once. Errors: as read_model.
  ModelDocument take(const CancelToken& cancel);

 private:
  const MeshCommand& command_;
  CancelToken stop_;
  std::future<ModelDocument> begun_;
};

}  // namespace tetloom::app
