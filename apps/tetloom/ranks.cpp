#include "apps/tetloom/ranks.hpp"

#include <cstdlib>
#include <initializer_list>

#ifdef TETLOOM_HAS_MPI
#include "tetloom/communicator.hpp"
#endif

namespace tetloom::app {
namespace {

/// The first of these variables that is set, as a number.
long from_environment(std::initializer_list<const char*> names, long otherwise) {
  for (const char* name : names)
    if (const char* text = std::getenv(name)) return std::strtol(text, nullptr, 10);
  return otherwise;
}

}  // namespace

#ifdef TETLOOM_HAS_MPI

struct Ranks::Session {
  MpiSession mpi;
};

Ranks::Ranks(int& argc, char**& argv) {
  if (is_one_of_several()) {
    session_.reset(new Session{MpiSession(argc, argv)});
    communicator_ = make_mpi_communicator();
  } else {
    communicator_ = make_thread_communicator();
  }
}

bool is_first_process() { return from_environment({"OMPI_COMM_WORLD_RANK", "PMI_RANK"}, 0) == 0; }

bool is_one_of_several() { return from_environment({"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}, 1) > 1; }

#else

struct Ranks::Session {};

Ranks::Ranks(int&, char**&) : communicator_(make_thread_communicator()) {}

bool is_first_process() { return true; }

bool is_one_of_several() { return false; }

#endif

Ranks::~Ranks() { communicator_.reset(); }

}  // namespace tetloom::app
