# SPDX-License-Identifier: Apache-2.0
# DRAM simulators of others, linked only when a build of them is named (docs/guide/dram-backends.md). Nothing of them is
# part of this project; without the two variables nothing changes.
#   GRTX_DRAMSYS    build directory of DRAMSys 5.1 to 5.5, configured with the SystemC that this build uses
#   GRTX_RAMULATOR  build directory of Ramulator 2.1
set(GRTX_DRAMSYS "" CACHE PATH "Build directory of DRAMSys; empty: without it")
set(GRTX_RAMULATOR "" CACHE PATH "Build directory of Ramulator 2.1; empty: without it")

# Sets grtx_NAME_source to the source directory that a build directory was configured from.
function(grtx_source_of_build option project)
  if(NOT EXISTS ${${option}}/CMakeCache.txt)
    message(FATAL_ERROR "${option}: ${${option}} is no build directory of ${project} (no CMakeCache.txt in it)")
  endif()
  load_cache(${${option}} READ_WITH_PREFIX grtx_found_ CMAKE_PROJECT_NAME CMAKE_HOME_DIRECTORY
                                           DRAMSYS_USE_FETCH_CONTENT_SYSTEMC DRAMSYS_USE_DRAMPOWER
                                           FETCHCONTENT_SOURCE_DIR_DRAMUTILS FETCHCONTENT_SOURCE_DIR_DRAMPOWER)
  if(NOT grtx_found_CMAKE_PROJECT_NAME STREQUAL project)
    message(FATAL_ERROR "${option}: ${${option}} is a build of ${grtx_found_CMAKE_PROJECT_NAME}, not of ${project}")
  endif()
  if(grtx_found_DRAMSYS_USE_FETCH_CONTENT_SYSTEMC)
    message(FATAL_ERROR "${option}: ${${option}} has a SystemC of its own; configure it with "
                        "-DDRAMSYS_USE_FETCH_CONTENT=OFF, so that both use the installed one")
  endif()
  set(grtx_source ${grtx_found_CMAKE_HOME_DIRECTORY} PARENT_SCOPE)
  set(grtx_uses_drampower "${grtx_found_DRAMSYS_USE_DRAMPOWER}" PARENT_SCOPE)
  foreach(fetched DRAMUTILS DRAMPOWER)  # as FetchContent finds them
    string(TOLOWER ${fetched} folder)
    set(found "${grtx_found_FETCHCONTENT_SOURCE_DIR_${fetched}}")
    if(NOT found)
      set(found ${${option}}/_deps/${folder}-src)
    endif()
    set(grtx_${folder} ${found} PARENT_SCOPE)
  endforeach()
endfunction()

function(grtx_need_files option)
  foreach(file ${ARGN})
    if(NOT EXISTS ${file})
      message(FATAL_ERROR "${option}: ${file} is missing; is the build complete, and of the right version?")
    endif()
  endforeach()
endfunction()

# Sets grtx_libraries, grtx_includes and grtx_definitions of the build of DRAMSys that GRTX_DRAMSYS names. Its headers and
# libraries lie elsewhere since 5.3; since 5.2 they include those of DRAMUtils and DRAMPower, which its build fetches or
# takes from where FETCHCONTENT_SOURCE_DIR_* says.
function(grtx_dramsys_layout)
  grtx_source_of_build(GRTX_DRAMSYS DRAMSys)
  if(EXISTS ${grtx_source}/src/DRAMSys)
    set(libraries ${GRTX_DRAMSYS}/lib/libdramsys.a)
    set(includes ${grtx_source}/src)
    set(headers DRAMSys/DRAMSys.h DRAMSys/configuration/json/DRAMSysConfiguration.h)
    list(TRANSFORM headers PREPEND ${grtx_source}/src/)
  else()
    set(libraries ${GRTX_DRAMSYS}/lib/liblibdramsys.a ${GRTX_DRAMSYS}/lib/libconfiguration.a)
    set(includes ${grtx_source}/src/libdramsys ${grtx_source}/src/configuration)
    set(headers ${grtx_source}/src/libdramsys/DRAMSys/simulation/DRAMSys.h
                ${grtx_source}/src/configuration/DRAMSys/config/DRAMSysConfiguration.h)
  endif()
  grtx_need_files(GRTX_DRAMSYS ${libraries} ${headers})
  set(definitions "")
  foreach(headers ${grtx_dramutils}/include ${grtx_drampower}/src/DRAMPower)
    if(EXISTS ${headers})
      list(APPEND includes ${headers})
    endif()
  endforeach()
  if(EXISTS ${GRTX_DRAMSYS}/lib/libDRAMPower.a)
    list(APPEND libraries ${GRTX_DRAMSYS}/lib/libDRAMPower.a)
    if(grtx_uses_drampower)
      set(definitions USE_DRAMPOWER)  # as DRAMSys itself was compiled: its classes have another function then
    endif()
  endif()
  set(grtx_libraries ${libraries} PARENT_SCOPE)
  set(grtx_includes ${includes} PARENT_SCOPE)
  set(grtx_definitions ${definitions} PARENT_SCOPE)
  set(grtx_source ${grtx_source} PARENT_SCOPE)
endfunction()

# Only the adapters see the simulators' headers; everything else is compiled as without them.
function(grtx_adapter_sources)
  cmake_parse_arguments(PARSE_ARGV 0 adapter "" "" "SOURCES;INCLUDES;DEFINITIONS")
  list(TRANSFORM adapter_INCLUDES PREPEND "-isystem" OUTPUT_VARIABLE includes)
  set_source_files_properties(
    ${adapter_SOURCES} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON COMPILE_OPTIONS "${includes}"
                                  COMPILE_DEFINITIONS "${adapter_DEFINITIONS}")
endfunction()

# grtx_add_dram_simulators(TARGET TABLE): adds the adapters of those that are named. TABLE: the source that lists them.
function(grtx_add_dram_simulators target table)
  set(listed "")
  if(GRTX_DRAMSYS)
    grtx_dramsys_layout()
    find_package(SQLite3 REQUIRED)
    target_sources(${target} PRIVATE ${dramsys_sources})
    grtx_adapter_sources(SOURCES ${dramsys_sources} INCLUDES ${grtx_includes} DEFINITIONS ${grtx_definitions}
                         "DRAMSYS_RESOURCE_DIR=\"${grtx_source}/configs\"")
    target_link_libraries(${target} PRIVATE ${grtx_libraries} ${SQLite3_LIBRARIES})
    list(APPEND listed GRTX_WITH_DRAMSYS)
  endif()
  if(GRTX_RAMULATOR)
    grtx_source_of_build(GRTX_RAMULATOR Ramulator)
    set(library ${grtx_source}/libramulator.so)
    grtx_need_files(GRTX_RAMULATOR ${library} ${grtx_source}/src/ramulator/frontend/i_frontend.h)
    target_sources(${target} PRIVATE ${ramulator_sources})
    grtx_adapter_sources(SOURCES ${ramulator_sources} INCLUDES ${grtx_source}/src)
    target_link_libraries(${target} PRIVATE ${library})
    list(APPEND listed GRTX_WITH_RAMULATOR)
    # What the tests and examples of commands use; the export needs Python, but nothing compiled.
    find_package(Python3 REQUIRED COMPONENTS Interpreter)
    foreach(memory gddr6 hbm2)
      execute_process(
        COMMAND ${CMAKE_COMMAND} -E env PYTHONPATH=${grtx_source}/python PYTHONDONTWRITEBYTECODE=1 ${Python3_EXECUTABLE}
                -m ramulator export ${PROJECT_SOURCE_DIR}/configs/dram/ramulator_${memory}.py -o
                ${PROJECT_BINARY_DIR}/ramulator_${memory}.yaml
        COMMAND_ERROR_IS_FATAL ANY)
    endforeach()
  endif()
  if(listed)
    set_source_files_properties(${table} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON COMPILE_DEFINITIONS "${listed}")
  endif()
endfunction()
