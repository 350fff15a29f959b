#pragma once
// The processes that run one command together.
#include <memory>

#include "tetloom/communicator.hpp"

namespace tetloom::app {

/// One process, or the ranks of MPI where a launcher such as mpirun started several. MPI is begun only then: a plain
/// run never calls it. Lives until the end of `main`.
class Ranks {
 public:
  Ranks(int& argc, char**& argv);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  Communicator& communicator() const { return *communicator_; }

 private:
  struct Session;
  std::unique_ptr<Session> session_;
  std::unique_ptr<Communicator> communicator_;
};

/// Whether this process speaks for the run: the only one, or the first of those that were started together, as the
/// launcher says in the environment.
bool is_first_process();
/// Whether others were started together with this process.
bool is_one_of_several();

}  // namespace tetloom::app
