#include "tests/threading/communicators.hpp"

std::unique_ptr<tetloom::Communicator> make_communicator() { return tetloom::make_thread_communicator(); }
