# The installed package: find_package(grtx_tlm), see grtx_tlm-config.cmake.in.
include(CMakePackageConfigHelpers)
get_property(grtx_installed GLOBAL PROPERTY grtx_installed_libraries)
list(JOIN grtx_installed ", " grtx_installed_words)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/grtx_tlm-config.cmake.in
                              ${PROJECT_BINARY_DIR}/package/grtx_tlm-config.cmake
                              INSTALL_DESTINATION ${GRTX_PACKAGE_FOLDER})
# Below version 1 a minor version may change the interfaces.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/grtx_tlm-config-version.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/package/grtx_tlm-config.cmake
              ${PROJECT_BINARY_DIR}/package/grtx_tlm-config-version.cmake DESTINATION ${GRTX_PACKAGE_FOLDER})
install(FILES ${PROJECT_SOURCE_DIR}/cmake/dependencies.cmake RENAME grtx_tlm-dependencies.cmake
        DESTINATION ${GRTX_PACKAGE_FOLDER})
install(FILES ${PROJECT_SOURCE_DIR}/cmake/verilator.cmake RENAME grtx_tlm-verilator.cmake
        DESTINATION ${GRTX_PACKAGE_FOLDER})
# For builds without CMake: grtx.pc, the hardware units and the GPU model. It names SystemC's own file, where there is one.
if(modules IN_LIST grtx_installed AND TARGET PkgConfig::SYSTEMC)
  set(grtx_pc_requires systemc tlm fmt libzstd libxxhash)
  set(grtx_pc_description "Transaction-level model of a GPU that traces 3D Gaussians: its hardware units")
  set(grtx_pc_libraries -lgrtx_modules -lgrtx_traces -lgrtx_base)
  if(sim IN_LIST grtx_installed)
    list(APPEND grtx_pc_requires nlohmann_json tomlplusplus)
    string(APPEND grtx_pc_description " and the GPU")
    list(PREPEND grtx_pc_libraries -lgrtx_sim)
  endif()
  list(JOIN grtx_pc_requires " " grtx_pc_requires)
  list(JOIN grtx_pc_libraries " " grtx_pc_libraries)
  set(grtx_pc_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  file(RELATIVE_PATH grtx_pc_to_prefix /prefix/${grtx_pc_folder} /prefix)
  string(REGEX REPLACE "/$" "" grtx_pc_to_prefix ${grtx_pc_to_prefix})
  configure_file(${PROJECT_SOURCE_DIR}/cmake/grtx.pc.in ${PROJECT_BINARY_DIR}/package/grtx.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/package/grtx.pc DESTINATION ${grtx_pc_folder})
endif()
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DATADIR}/grtx_tlm)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
