# The installed CMake package: find_package(tetloom) gives tetloom::core, ::cad, ::discrete, ::threading, ::geometry,
# ::mesher and ::adapt.
# The headers are those of include/tetloom, included as <tetloom/mesh.hpp>; nothing else is installed.
include(CMakePackageConfigHelpers)

get_property(tetloom_libraries GLOBAL PROPERTY TETLOOM_LIBRARIES)
get_property(tetloom_executables GLOBAL PROPERTY TETLOOM_EXECUTABLES)
set(tetloom_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tetloom)

install(TARGETS ${tetloom_libraries} EXPORT tetloomTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(tetloom_executables)
  install(TARGETS ${tetloom_executables} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY include/tetloom DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp")
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(tetloom_bin_dir ${CMAKE_INSTALL_BINDIR})
configure_package_config_file(cmake/tetloomConfig.cmake.in ${PROJECT_BINARY_DIR}/tetloomConfig.cmake
                              INSTALL_DESTINATION ${tetloom_package_dir} PATH_VARS tetloom_bin_dir
                              NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/tetloomConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/tetloomConfig.cmake ${PROJECT_BINARY_DIR}/tetloomConfigVersion.cmake
              cmake/FindScotch.cmake cmake/FindZoltan.cmake
        DESTINATION ${tetloom_package_dir})
install(EXPORT tetloomTargets NAMESPACE tetloom:: DESTINATION ${tetloom_package_dir})
