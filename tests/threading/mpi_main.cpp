// Runs the same tests on every rank; the ranks agree on their order.
#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "tests/support/sanitized.hpp"
#include "tests/threading/communicators.hpp"
#include "tetloom/communicator.hpp"

std::unique_ptr<tetloom::Communicator> make_communicator() { return tetloom::make_mpi_communicator(10'000); }

unsigned migration_seeds() { return tetloom::test::kSanitized ? 10 : 20; }

int main(int argc, char** argv) {
  const tetloom::MpiSession mpi(argc, argv);
  return Catch::Session().run(argc, argv);
}
