# SPDX-License-Identifier: Apache-2.0
# A library of the project: all .cpp files of its folder, the aliases and what installing it takes.
include(GNUInstallDirs)

# Sets VARIABLE to the sources below the current folder. A folder without any is a mistake (a wrong move, a glob that
# missed), which otherwise shows as an empty archive and a page of undefined symbols.
function(grtx_sources variable pattern)
  file(GLOB_RECURSE found CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${pattern})
  if(NOT found)
    message(FATAL_ERROR "${CMAKE_CURRENT_SOURCE_DIR} holds no ${pattern}")
  endif()
  set(${variable} ${found} PARENT_SCOPE)
endfunction()

# grtx_library(NAME [SOURCES file...] [PUBLIC library...] [PRIVATE library...]): the target grtx_NAME, for others
# grtx::NAME. SOURCES: those in place of all .cpp files of the folder. Own libraries come before those of others, and the
# project's own warnings and flags stay inside. What is installed of its headers: install_headers.cmake.
function(grtx_library name)
  cmake_parse_arguments(PARSE_ARGV 1 library "" "" "SOURCES;PUBLIC;PRIVATE")
  if(NOT library_SOURCES)
    grtx_sources(library_SOURCES *.cpp)
  endif()
  add_library(grtx_${name} ${library_SOURCES})  # static unless BUILD_SHARED_LIBS
  add_library(grtx::${name} ALIAS grtx_${name})
  # Position-independent as static libraries, too: simulator plug-ins and Python extensions are shared libraries that link
  # them. Functions of ours are not replaced from outside, so they stay as fast as before.
  set_target_properties(grtx_${name} PROPERTIES EXPORT_NAME ${name} GRTX_OWN ON POSITION_INDEPENDENT_CODE ON
                                                VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
                                                INSTALL_RPATH "$<$<BOOL:${BUILD_SHARED_LIBS}>:$ORIGIN>"  # they stand on each other
                                                DEFINE_SYMBOL "")  # objects are the same in both kinds of library
  target_compile_options(grtx_${name} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>)
  target_compile_features(grtx_${name} PUBLIC cxx_std_20)
  target_include_directories(grtx_${name} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                                                 $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(grtx_${name} PRIVATE $<BUILD_INTERFACE:grtx_options>)
  foreach(below ${grtx_${name}_stands_on})
    target_link_libraries(grtx_${name} PUBLIC grtx_${below})
  endforeach()
  target_link_libraries(grtx_${name} PUBLIC ${library_PUBLIC} PRIVATE ${library_PRIVATE})

  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
  string(REGEX MATCH "^[^/]+" folder ${folder})
  install(TARGETS grtx_${name} EXPORT grtx_${name} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT dev)
  set_property(GLOBAL APPEND PROPERTY grtx_installed_folders ${folder})
  install(EXPORT grtx_${name} NAMESPACE grtx:: FILE grtx_tlm-${name}.cmake DESTINATION ${GRTX_PACKAGE_FOLDER})
  set_property(GLOBAL APPEND PROPERTY grtx_installed_libraries ${name})
endfunction()
