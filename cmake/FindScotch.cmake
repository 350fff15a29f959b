# Scotch::scotch. Debian's package has no CMake files. The error libraries are left out on purpose: tetloom_threading
# defines the functions through which Scotch reports.
include(FindPackageHandleStandardArgs)
find_path(Scotch_INCLUDE_DIR scotch.h PATH_SUFFIXES scotch)
find_library(Scotch_LIBRARY scotch)
find_package_handle_standard_args(Scotch REQUIRED_VARS Scotch_LIBRARY Scotch_INCLUDE_DIR)
mark_as_advanced(Scotch_INCLUDE_DIR Scotch_LIBRARY)
if(Scotch_FOUND AND NOT TARGET Scotch::scotch)
  add_library(Scotch::scotch UNKNOWN IMPORTED)
  set_target_properties(Scotch::scotch PROPERTIES IMPORTED_LOCATION ${Scotch_LIBRARY}
                                                  INTERFACE_INCLUDE_DIRECTORIES ${Scotch_INCLUDE_DIR})
endif()
