# SPDX-License-Identifier: Apache-2.0
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
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DATADIR}/grtx_tlm)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
