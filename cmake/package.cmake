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
  set(grtx_pc_requires "systemc = ${GRTX_SYSTEMC_VERSION}" tlm fmt libzstd libxxhash)
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
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DATADIR}/grtx_tlm COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
file(GLOB grtx_examples ${PROJECT_SOURCE_DIR}/examples/*.cpp ${PROJECT_SOURCE_DIR}/examples/*.sv)
install(FILES ${grtx_examples} DESTINATION ${CMAKE_INSTALL_DATADIR}/grtx_tlm/examples)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/grtx_tlm DESTINATION lib/python3/dist-packages COMPONENT python
        FILES_MATCHING PATTERN *.py PATTERN py.typed PATTERN __pycache__ EXCLUDE)  # where Debian's Python looks

# Packages, as Debian has them: grtx-tlm, whose needs dpkg-shlibdeps finds, grtx-tlm-dev, which brings all that
# find_package(grtx_tlm) looks for, python3-grtx-tlm, and libgrtx-tlmVERSION where BUILD_SHARED_LIBS is on, as in
# scripts/deb.sh. Configure with -DCMAKE_INSTALL_PREFIX=/usr.
if(PROJECT_IS_TOP_LEVEL)
  set(CPACK_PACKAGE_NAME grtx-tlm)
  set(CPACK_PACKAGE_VENDOR "The GRTX-TLM authors")
  set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
      "Transaction-level model of ray-tracing hardware for 3D Gaussians
GRTX-TLM renders scenes of 3D Gaussians by ray tracing and writes what every
ray did into a trace. A SystemC model replays the trace, cycle by cycle, on a
GPU of ray-tracing units, shader cores, caches and DRAM, and prices it in area
and energy. The package holds the program grtx and its machines.")
  set(CPACK_COMPONENT_DEV_DESCRIPTION
      "Transaction-level model of ray-tracing hardware (development files)
The libraries, their public headers, CMake package and pkg-config file, for
programs that link the tracer, the hardware units or the whole GPU.")
  set(CPACK_COMPONENT_LIBRARY_DESCRIPTION
      "Transaction-level model of ray-tracing hardware (libraries)
The shared libraries: the tracer, the hardware units, the whole GPU as a
SystemC module, cost, sweeps and reports.")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION
      "Transaction-level model of ray-tracing hardware (Python)
Runs the program grtx, and reads its statistics, results and sweeps as pandas
frames, and traces as arrays.")
  set(CPACK_PACKAGE_CONTACT "The GRTX-TLM authors <grtx-tlm@invalid>")  # RELEASING.md, "Before the first"
  set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(CPACK_STRIP_FILES ON)
  set(CPACK_GENERATOR DEB)
  set(CPACK_COMPONENTS_ALL program dev python)
  set(grtx_deb_library "")
  if(BUILD_SHARED_LIBS)
    list(APPEND CPACK_COMPONENTS_ALL library)
    set(grtx_deb_library libgrtx-tlm${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})  # as their SONAMEs
  endif()
  set(CPACK_DEB_COMPONENT_INSTALL ON)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME grtx-tlm)
  set(CPACK_DEBIAN_DEV_PACKAGE_NAME grtx-tlm-dev)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-grtx-tlm)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME ${grtx_deb_library})
  # One name for each distribution, whose libraries it was linked with: grtx-tlm_1.0.0-1~debian12_amd64.deb.
  cmake_host_system_information(RESULT grtx_system QUERY DISTRIB_ID DISTRIB_VERSION_ID)
  list(JOIN grtx_system "" grtx_system)
  set(CPACK_DEBIAN_PACKAGE_RELEASE 1~${grtx_system})
  string(REPLACE - ~ grtx_deb_suffix "${GRTX_VERSION_SUFFIX}")  # 1.1.0~dev comes before 1.1.0
  set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION}${grtx_deb_suffix})
  set(grtx_deb_version ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
  set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "python3-grtx-tlm, gtkwave")
  if(BUILD_SHARED_LIBS)
    # Without a promise of binary compatibility (docs/api.md) who links them needs these very ones.
    set(grtx_deb_exactly "${grtx_deb_library} (= ${grtx_deb_version}), ")
    set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "${grtx_deb_library} (= ${grtx_deb_version})")
    set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
    foreach(library ${grtx_installed})
      get_target_property(folder grtx_${library} BINARY_DIR)
      list(APPEND CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${folder})
    endforeach()
  endif()
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_LIBRARY_PACKAGE_RECOMMENDS "grtx-tlm (= ${grtx_deb_version})")  # has the machines
  set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
  set(grtx_deb_needs
      libcli11-dev libembree-dev libfmt-dev libglm-dev libopenexr-dev libpagmo-dev libpng-dev libsqlite3-dev libsystemc-dev
      libtbb-dev libtomlplusplus-dev libwebp-dev libxxhash-dev libzip-dev libzstd-dev nlohmann-json3-dev pkgconf
      zlib1g-dev)  # all of dependencies.cmake
  list(JOIN grtx_deb_needs ", " grtx_deb_needs)
  set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "${grtx_deb_exactly}grtx-tlm (= ${grtx_deb_version}), ${grtx_deb_needs}")
  set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "cmake (>= 3.25), g++ (>= 4:12)")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "python3 (>= 3.11), python3-numpy (>= 1:1.24), python3-pandas (>= 1.5), python3-matplotlib (>= 3.6)")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "grtx-tlm (= ${grtx_deb_version})")
  set(grtx_deb_scripts ${PROJECT_SOURCE_DIR}/packaging/debian/python3-grtx-tlm)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${grtx_deb_scripts}/postinst ${grtx_deb_scripts}/prerm)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
  # What Debian's policy asks for beside what is installed anyway.
  set(grtx_deb_charts "")
  if(GRTX_BUILD_REPORT AND GRTX_REPORT_CHARTS)
    set(grtx_deb_charts ${GRTX_CHARTS_FOLDER}/node_modules)
  endif()
  configure_file(${PROJECT_SOURCE_DIR}/cmake/deb_files.cmake.in ${PROJECT_BINARY_DIR}/package/deb_files.cmake @ONLY)
  set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_BINARY_DIR}/package/deb_files.cmake)
  include(CPack)
endif()
