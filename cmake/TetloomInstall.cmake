# The installed CMake package: find_package(tetloom) gives tetloom::core, ::cad, ::discrete, ::threading, ::mesher and
# ::adapt.
# Headers lie under include/tetloom and are included as in the checkout: "mesher/mesher.hpp". Private headers
# (detail/, *_detail.hpp and everything of threading, mesher and adapt but their public headers) stay behind.
include(CMakePackageConfigHelpers)

get_property(tetloom_libraries GLOBAL PROPERTY TETLOOM_LIBRARIES)
get_property(tetloom_executables GLOBAL PROPERTY TETLOOM_EXECUTABLES)
set(tetloom_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/tetloom)
set(tetloom_include_dir ${CMAKE_INSTALL_INCLUDEDIR}/tetloom)

install(TARGETS ${tetloom_libraries} EXPORT tetloomTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(tetloom_executables)
  install(TARGETS ${tetloom_executables} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
foreach(folder base geometry mesh part io sizing predicates)
  install(DIRECTORY core/${folder}/ DESTINATION ${tetloom_include_dir}/core/${folder}
          FILES_MATCHING PATTERN "*.hpp" PATTERN "*_detail.hpp" EXCLUDE PATTERN detail EXCLUDE)
endforeach()
install(FILES threading/communicator.hpp threading/message.hpp threading/partitioned_mesh.hpp threading/parts_io.hpp
              threading/schedule.hpp threading/task_runner.hpp threading/trace.hpp threading/whole_mesh.hpp
        DESTINATION ${tetloom_include_dir}/threading)
install(FILES mesher/mesh_in_parts.hpp mesher/mesher.hpp DESTINATION ${tetloom_include_dir}/mesher)
install(FILES mesher/features/absorbed_entity.hpp DESTINATION ${tetloom_include_dir}/mesher/features)
install(FILES mesher/lattice/lattice_kind.hpp DESTINATION ${tetloom_include_dir}/mesher/lattice)
install(FILES mesher/volume/volume_mesher.hpp DESTINATION ${tetloom_include_dir}/mesher/volume)
install(FILES mesher/tets/acute_tets.hpp mesher/tets/optimizer.hpp mesher/tets/quality_goals.hpp mesher/tets/tet_mesh.hpp
        DESTINATION ${tetloom_include_dir}/mesher/tets)
install(FILES adapt/adapt.hpp DESTINATION ${tetloom_include_dir}/adapt)
install(FILES adapt/kernel/pass_counts.hpp DESTINATION ${tetloom_include_dir}/adapt/kernel)
install(FILES adapt/metric/curvature_limits.hpp adapt/metric/hessian.hpp adapt/metric/metric_field.hpp adapt/metric/tensor.hpp
              adapt/metric/vertex_graph.hpp
        DESTINATION ${tetloom_include_dir}/adapt/metric)
if(TETLOOM_CAD)
  install(FILES core/cad/read_model.hpp DESTINATION ${tetloom_include_dir}/core/cad)
endif()
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
