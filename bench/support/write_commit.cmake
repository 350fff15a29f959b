# Writes OUTPUT, a header that names the commit of SOURCE, and leaves the file alone where nothing changed.
cmake_minimum_required(VERSION 3.25)
if(NOT COMMIT AND GIT)
  execute_process(COMMAND ${GIT} describe --always --dirty --abbrev=12 WORKING_DIRECTORY ${SOURCE}
                  OUTPUT_VARIABLE COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT COMMIT)
  set(COMMIT unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT "#pragma once\n#define TETLOOM_COMMIT \"@COMMIT@\"\n" @ONLY)
