# SPDX-License-Identifier: Apache-2.0
# The installed package: find_package(grtx_tlm), see grtx_tlm-config.cmake.in.
include(CMakePackageConfigHelpers)
get_property(grtx_installed GLOBAL PROPERTY grtx_installed_libraries)
list(JOIN grtx_installed ", " grtx_installed_words)
get_property(grtx_folders GLOBAL PROPERTY grtx_installed_folders)
install(CODE "set(SOURCE ${PROJECT_SOURCE_DIR})
set(FOLDERS \"${grtx_folders}\")
set(DESTINATION \${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/grtx)
include(\${SOURCE}/cmake/install_headers.cmake)")
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/grtx_tlm-config.cmake.in
                              ${PROJECT_BINARY_DIR}/package/grtx_tlm-config.cmake
                              INSTALL_DESTINATION ${GRTX_PACKAGE_FOLDER})
# Minor versions keep the public interfaces (docs/api.md).
write_basic_package_version_file(${PROJECT_BINARY_DIR}/package/grtx_tlm-config-version.cmake
                                 COMPATIBILITY SameMajorVersion)
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

# Packages: cpack --config build/release/CPackConfig.cmake -G DEB. Configure with -DCMAKE_INSTALL_PREFIX=/usr. What the
# program needs is found by dpkg-shlibdeps; who compiles against the libraries also needs the -dev packages of
# cmake/dependencies.cmake, which are recommended.
if(PROJECT_IS_TOP_LEVEL)
  set(CPACK_PACKAGE_NAME grtx-tlm)
  set(CPACK_PACKAGE_VENDOR "The GRTX-TLM authors")
  set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Transaction-level model of ray-tracing hardware for 3D Gaussians")
  set(CPACK_PACKAGE_DESCRIPTION
      "GRTX-TLM renders scenes of 3D Gaussians by ray tracing and writes what every ray
did into a trace. A SystemC model replays the trace, cycle by cycle, on a GPU of
ray-tracing units, shader cores, caches and DRAM, and prices it in area and energy.
The package holds the program grtx, the libraries, their headers and machines.")
  set(CPACK_PACKAGE_CONTACT "The GRTX-TLM authors <grtx-tlm@invalid>")  # RELEASING.md, "Before the first"
  set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_GENERATOR DEB)
  # One name for each distribution, whose libraries it was linked with: grtx-tlm_1.0.0-1~debian12_amd64.deb.
  cmake_host_system_information(RESULT grtx_system QUERY DISTRIB_ID DISTRIB_VERSION_ID)
  list(JOIN grtx_system "" grtx_system)
  set(CPACK_DEBIAN_PACKAGE_RELEASE 1~${grtx_system})
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
      "libsystemc-dev, libembree-dev, libfmt-dev, libxxhash-dev, libzstd-dev, nlohmann-json3-dev, libtomlplusplus-dev")
  set(CPACK_DEBIAN_PACKAGE_SUGGESTS "python3-pandas, python3-matplotlib, gtkwave")
  include(CPack)
endif()
