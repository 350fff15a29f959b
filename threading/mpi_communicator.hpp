#pragma once
// Parts on several MPI ranks. Only where TETLOOM_MPI is on.
#include <cstddef>
#include <memory>

#include "threading/communicator.hpp"

namespace tetloom {

/// MPI from the beginning to the end of `main`. Errors: Error(Internal) when MPI cannot be called from changing
/// threads.
class MpiSession {
 public:
  MpiSession(int& argc, char**& argv);
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;
};

/// Several parts on each rank of MPI_COMM_WORLD, over a duplicate of it. All ranks make and destroy it together, inside
/// a session (or after the host's own MPI_Init_thread with MPI_THREAD_SERIALIZED).
///
/// During a run a thread of the communicator's own makes all calls of MPI; the host makes none then. Messages are cut
/// into pieces of at most `largest_piece` bytes (below 2 GiB), the same on all ranks; a message may have any size.
std::unique_ptr<Communicator> make_mpi_communicator(std::size_t largest_piece = std::size_t{64} << 20);

}  // namespace tetloom
