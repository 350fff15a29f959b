# How every target of tetloom is built: one place for the language level, the warnings, the sanitizers and the
# include root.
find_package(Threads REQUIRED)
find_program(TETLOOM_CCACHE ccache)
if(TETLOOM_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${TETLOOM_CCACHE})
  if(TETLOOM_PCH)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${TETLOOM_CCACHE})
  endif()
endif()
# What nearly every source includes. A build with these headers precompiled is sooner done and does not see that a
# source forgets one: scripts/check_imports.py does.
set(TETLOOM_COMMON_HEADERS <algorithm> <array> <atomic> <bit> <cmath> <cstdint> <cstring> <filesystem> <functional>
                           <limits> <map> <memory> <mutex> <numbers> <numeric> <optional> <set> <span> <string>
                           <string_view> <tuple> <unordered_map> <utility> <vector>)

if(TETLOOM_MOLD)
  find_program(TETLOOM_MOLD_LINKER mold)
  if(TETLOOM_MOLD_LINKER)
    add_link_options(-fuse-ld=mold)
  endif()
endif()

function(tetloom_configure target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  # -ffp-contract=off: a mesh must not depend on whether the compiler fuses a multiplication and an addition.
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
                                           -Werror=return-type -ffp-contract=off)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    # GCC 12 sees overlapping copies in every "text" + std::string (GCC bug 105651).
    target_compile_options(${target} PRIVATE -Wno-restrict)
  endif()
  if(TETLOOM_SANITIZE)
    target_compile_options(${target} PUBLIC -fsanitize=${TETLOOM_SANITIZE} -fno-omit-frame-pointer
                                            -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=${TETLOOM_SANITIZE})
    if(TETLOOM_SANITIZE MATCHES "address.*undefined")
      # AddressSanitizer ends at a null pointer as well; these checks make sources a fifth longer to compile.
      target_compile_options(${target} PUBLIC -fno-sanitize=null,alignment,object-size,vptr)
    endif()
  endif()
endfunction()

# Precompiles the common headers, and the given ones, for the sources of a target.
function(tetloom_precompile target)
  if(TETLOOM_PCH)
    target_precompile_headers(${target} PRIVATE ${TETLOOM_COMMON_HEADERS} ${ARGN})
  endif()
endfunction()

# A library of the project, installed as tetloom::<name> and usable under that name inside the build as well.
function(tetloom_library name)
  add_library(tetloom_${name} STATIC ${ARGN})
  add_library(tetloom::${name} ALIAS tetloom_${name})
  set_target_properties(tetloom_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(tetloom_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>
                                                    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                                                    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  tetloom_configure(tetloom_${name})
  tetloom_precompile(tetloom_${name})
  set_property(GLOBAL APPEND PROPERTY TETLOOM_LIBRARIES tetloom_${name})
endfunction()

# With sanitizers, sources full of assertions take more than twice as long to compile when they are optimised.
function(tetloom_leave_assertions_slow target)
  if(TETLOOM_SANITIZE)
    target_compile_options(${target} PRIVATE -O0)
  endif()
endfunction()

# Builds an executable of tests as tests are built, with the precompiled headers of all tests.
function(tetloom_configure_test target)
  tetloom_configure(${target})
  tetloom_leave_assertions_slow(${target})
  if(TETLOOM_PCH)
    # One set of precompiled headers needs one code model: that of a library.
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${target} PRIVATE -fPIC)
    target_precompile_headers(${target} REUSE_FROM tetloom_test_support)
  endif()
endfunction()

# A Catch2 test executable, registered with CTest under its own name.
function(tetloom_test name)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "" "SOURCES;LIBRARIES;LABELS")
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_LIBRARIES} tetloom_test_main)
  tetloom_configure_test(${name})
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES LABELS "${ARG_LABELS}")
endfunction()
