#pragma once
// The communicator that the tests of this executable are run on: threads in one, MPI in the other.
#include <memory>

#include "tetloom/communicator.hpp"

std::unique_ptr<tetloom::Communicator> make_communicator();

/// How many random meshes to try: fewer where messages take their time.
unsigned migration_seeds();
