# SPDX-License-Identifier: Apache-2.0
# Blocks of the RT unit as RTL (docs/model/rtl_bridge.md): with Debian's Verilator where it is found; without it nothing
# changes but that rt.checkpoint.implementation = rtl is refused. Installed with the package, for blocks of others:
# include(${grtx_tlm_DIR}/grtx_tlm-verilator.cmake) (docs/guide/own-rtl.md).
if(NOT GRTX_INSTALLED)
  set(grtx_rtl_folder ${PROJECT_SOURCE_DIR}/rtl_tlm/rtl)
endif()  # else grtx_tlm-config.cmake says where they are, and whether the library has Verilator's runtime
option(GRTX_RTL "Build the Verilated units, where Verilator is found" ON)
set(grtx_rtl_found FALSE)
if(GRTX_RTL)
  find_package(verilator 5.006 QUIET HINTS /usr/share/verilator $ENV{VERILATOR_ROOT})
  set(grtx_rtl_found ${verilator_FOUND})
endif()
if(grtx_rtl_found)
  message(STATUS "RTL in the loop: Verilator ${verilator_VERSION}")
else()
  message(STATUS "RTL in the loop: off (no Verilator 5.006; apt-get install verilator)")
endif()

# grtx_verilated_blocks(TARGET): an object library for blocks of grtx_verilate(). Generated code is compiled without the
# project's warnings.
function(grtx_verilated_blocks target)
  add_library(${target} OBJECT)
  set_target_properties(${target} PROPERTIES UNITY_BUILD OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -O3 -w)
endfunction()

# grtx_verilate(TARGET PREFIX TOP [SOURCES file...] [ARGS argument...]): adds the class PREFIX that Verilator makes of a
# module. `include "fp32.svh" works.
function(grtx_verilate target prefix top)
  cmake_parse_arguments(PARSE_ARGV 3 block "" "" "SOURCES;ARGS")
  verilate(${target} PREFIX ${prefix} TOP_MODULE ${top} SOURCES ${block_SOURCES}
           VERILATOR_ARGS -O3 -I${grtx_rtl_folder} ${block_ARGS})
  # Verilator's runtime is in grtx::sim where that has RTL; twice in a program it does not link.
  if(target STREQUAL grtx_rtl OR (GRTX_INSTALLED AND NOT (GRTX_HAS_RUNTIME AND TARGET grtx::sim)))
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  list(FILTER sources EXCLUDE REGEX "/verilated(_threads)?\\.cpp$")
  set_target_properties(${target} PROPERTIES SOURCES "${sources}")
endfunction()

# grtx_link_blocks(PROGRAM TARGET): links the blocks; their classes' headers count as the system's.
function(grtx_link_blocks program target)
  target_link_libraries(${program} PRIVATE ${target})
  get_target_property(includes ${target} INCLUDE_DIRECTORIES)
  target_include_directories(${program} SYSTEM PRIVATE ${includes})
endfunction()
