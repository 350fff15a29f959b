#include "tests/support/sanitized.hpp"
#include "tests/threading/communicators.hpp"

std::unique_ptr<tetloom::Communicator> make_communicator() { return tetloom::make_thread_communicator(); }

unsigned migration_seeds() { return tetloom::test::kSanitized ? 40 : 400; }
