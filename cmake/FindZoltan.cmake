# Zoltan::zoltan of Trilinos, with MPI. Debian's own CMake files of Zoltan name libraries by absolute paths and leave
# MPI out.
include(FindPackageHandleStandardArgs)
find_package(MPI QUIET COMPONENTS CXX)
find_path(Zoltan_INCLUDE_DIR zoltan.h PATH_SUFFIXES trilinos)
find_library(Zoltan_LIBRARY NAMES trilinos_zoltan zoltan)
find_package_handle_standard_args(Zoltan REQUIRED_VARS Zoltan_LIBRARY Zoltan_INCLUDE_DIR MPI_CXX_FOUND)
mark_as_advanced(Zoltan_INCLUDE_DIR Zoltan_LIBRARY)
if(Zoltan_FOUND AND NOT TARGET Zoltan::zoltan)
  add_library(Zoltan::zoltan UNKNOWN IMPORTED)
  set_target_properties(Zoltan::zoltan PROPERTIES IMPORTED_LOCATION ${Zoltan_LIBRARY}
                                                  INTERFACE_INCLUDE_DIRECTORIES ${Zoltan_INCLUDE_DIR}
                                                  INTERFACE_LINK_LIBRARIES MPI::MPI_CXX)
endif()
