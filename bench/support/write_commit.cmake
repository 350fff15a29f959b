# Writes OUTPUT, a source file that names the commit of SOURCE, and leaves it alone where nothing changed.
cmake_minimum_required(VERSION 3.25)
if(NOT COMMIT AND GIT)
  execute_process(COMMAND ${GIT} describe --always --dirty --abbrev=12 WORKING_DIRECTORY ${SOURCE}
                  OUTPUT_VARIABLE COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT COMMIT)
  set(COMMIT unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
#include "bench/support/commit.hpp"
const char* const tetloom::bench::kCommit = "@COMMIT@";
]])
