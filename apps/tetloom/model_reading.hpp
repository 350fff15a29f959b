#pragma once
// The model of a run, read while its ranks find each other.
#include <future>

#include "apps/tetloom/options.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/host.hpp"
#include "tetloom/model.hpp"

namespace tetloom::app {

/// Reads a model on `threads` threads; 0: on all cores. Errors: as read_model.
ModelDocument read(const std::filesystem::path& path, const ReadOptions& options, int threads,
                   const CancelToken& cancel);

/// Reads a model for all ranks: see read_model_on_ranks. A collective call.
ModelDocument read_on_ranks(const std::filesystem::path& path, const ReadOptions& options, int threads,
                            const CancelToken& cancel, Communicator& communicator);

/// Starting MPI takes about as long as reading a small model, and it mostly waits: where several ranks were started
/// together, the first begins to read at once, in a thread of its own.
class ModelReading {
 public:
  explicit ModelReading(const MeshCommand& command);
  /// Ends a reading that nobody waits for.
  ~ModelReading();
  ModelReading(const ModelReading&) = delete;
  ModelReading& operator=(const ModelReading&) = delete;

  /// The model, for all ranks; read here and now where that has not begun before. A collective call, to be made once.
  /// Errors: as read_model_on_ranks.
  ModelDocument take(const CancelToken& cancel, Communicator& communicator);

 private:
  ModelDocument take_own(const CancelToken& cancel);

  const MeshCommand& command_;
  CancelToken stop_;
  std::future<ModelDocument> begun_;
};

}  // namespace tetloom::app
