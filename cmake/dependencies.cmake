# SPDX-License-Identifier: Apache-2.0
# What each library of the project needs. The build includes this file, and so does the installed package
# (grtx_tlm-config.cmake), so that both look things up alike. All of it are Debian packages
# (scripts/install_dependencies.sh); what a library that is not built needs is not looked for.
set(grtx_libraries base traces frontend modules sim explore report experiment program)
set(grtx_base_stands_on)
set(grtx_traces_stands_on base)
set(grtx_frontend_stands_on base traces)
set(grtx_modules_stands_on base traces)
set(grtx_sim_stands_on base traces modules)
set(grtx_explore_stands_on base traces modules sim)
set(grtx_report_stands_on base traces modules sim explore)
set(grtx_experiment_stands_on base traces frontend modules sim explore report)
set(grtx_program_stands_on base traces frontend modules sim explore report experiment)

# grtx_find(NAME [VERSION]): find_package() that must succeed; in the installed package, what a user's
# find_package(grtx_tlm) passes on. One line says what is needed and what was found. The versions are the oldest that the
# tests have run with, but for SystemC 2.3.3, Spack's only one, which nobody has tried. They are compared here: some
# packages (pagmo) refuse a request for an older minor version.
macro(grtx_find name)
  if(GRTX_INSTALLED)
    find_dependency(${name})
  else()
    find_package(${name} QUIET)
    set(grtx_found "${${name}_VERSION}")
    if(NOT grtx_found)
      set(grtx_found "${${name}_VERSION_STRING}")
    endif()
    if(NOT ${name}_FOUND)
      message(FATAL_ERROR "${name} ${ARGN} or later is needed, found: none (docs/guide/install.md)")
    elseif(NOT "${ARGN}" STREQUAL "" AND grtx_found AND grtx_found VERSION_LESS "${ARGN}")
      message(FATAL_ERROR "${name} ${ARGN} or later is needed, found: ${grtx_found} (docs/guide/install.md)")
    endif()
  endif()
endmacro()

# Makes the target PkgConfig::NAME of pkg-config modules.
macro(grtx_find_modules name)
  grtx_find(PkgConfig)
  if(NOT TARGET PkgConfig::${name})
    pkg_check_modules(${name} QUIET IMPORTED_TARGET GLOBAL ${ARGN})
    if(NOT ${name}_FOUND AND GRTX_INSTALLED)
      set(${CMAKE_FIND_PACKAGE_NAME}_FOUND FALSE)
      set(${CMAKE_FIND_PACKAGE_NAME}_NOT_FOUND_MESSAGE "pkg-config does not know ${ARGN}")
      return()
    elseif(NOT ${name}_FOUND)
      message(FATAL_ERROR "${ARGN} or later is needed, pkg-config finds none such (docs/guide/install.md)")
    endif()
  endif()
endmacro()

# SystemC as grtx::systemc: the CMake package if there is one, else pkg-config (Debian ships no CMake package).
# The library's symbols name the version, and the C++ version that it was built with, C++17 on most systems; SC_CPLUSPLUS,
# a documented hook, lets C++20 code link with it. It belongs to whoever includes <systemc>, however SystemC was found.
# The installed package takes no other SystemC than the libraries were built with.
macro(grtx_find_systemc)
  if(NOT TARGET grtx::systemc)
    find_package(SystemCLanguage CONFIG QUIET HINTS ${GRTX_SYSTEMC_PLACE})
    if(SystemCLanguage_FOUND)
      set(grtx_systemc_library SystemC::systemc)
      set(grtx_systemc_place ${SystemCLanguage_DIR})
    else()
      grtx_find_modules(SYSTEMC systemc>=2.3.3 tlm)
      set(grtx_systemc_library PkgConfig::SYSTEMC)
      set(grtx_systemc_place ${SYSTEMC_systemc_PREFIX})
    endif()
    if(GRTX_INSTALLED)
      grtx_try_systemc(${grtx_systemc_library} ${GRTX_SC_CPLUSPLUS})
      set(grtx_systemc_wrong "")
      if(NOT grtx_systemc_version STREQUAL GRTX_SYSTEMC_VERSION)
        set(grtx_systemc_wrong "is ${grtx_systemc_version}")
      elseif(NOT grtx_systemc_links)
        set(grtx_systemc_wrong "does not link with SC_CPLUSPLUS=${GRTX_SC_CPLUSPLUS}")
      endif()
      if(grtx_systemc_wrong)
        set(${CMAKE_FIND_PACKAGE_NAME}_FOUND FALSE)
        set(${CMAKE_FIND_PACKAGE_NAME}_NOT_FOUND_MESSAGE
            "the libraries were built with SystemC ${GRTX_SYSTEMC_VERSION} of ${GRTX_SYSTEMC_PLACE}, that of ${grtx_systemc_place} ${grtx_systemc_wrong}")
        return()
      endif()
    elseif(NOT GRTX_SYSTEMC_VERSION OR NOT GRTX_SYSTEMC_PLACE STREQUAL grtx_systemc_place)
      grtx_choose_systemc(${grtx_systemc_library} "${grtx_systemc_place}")
    endif()
    add_library(grtx::systemc INTERFACE IMPORTED GLOBAL)
    target_link_libraries(grtx::systemc INTERFACE ${grtx_systemc_library})
    target_compile_definitions(grtx::systemc INTERFACE SC_CPLUSPLUS=${GRTX_SC_CPLUSPLUS})
  endif()
endmacro()

# Compiles a program with SystemC: grtx_systemc_version is what its header says, "unknown" if it does not compile, and
# grtx_systemc_links whether the library is of that version and of this SC_CPLUSPLUS.
function(grtx_try_systemc library cplusplus)
  set(folder ${CMAKE_BINARY_DIR}/CMakeFiles/grtx_systemc)
  file(WRITE ${folder}/version.cpp
       "#include <systemc>
#define TEXT(x) #x
#define VERSION(a, b, c) \"grtx_systemc_version=\" TEXT(a) \".\" TEXT(b) \".\" TEXT(c) \";\"
extern const char version[];
const char version[] = VERSION(SC_VERSION_MAJOR, SC_VERSION_MINOR, SC_VERSION_PATCH);
int sc_main(int argc, char*[]) { return version[argc]; }
")
  set(found unknown)
  set(links FALSE)
  foreach(kind EXECUTABLE STATIC_LIBRARY)
    set(CMAKE_TRY_COMPILE_TARGET_TYPE ${kind})
    try_compile(tried ${folder}/${kind} SOURCES ${folder}/version.cpp COMPILE_DEFINITIONS -DSC_CPLUSPLUS=${cplusplus}
                LINK_LIBRARIES ${library} CXX_STANDARD 20 CXX_STANDARD_REQUIRED ON COPY_FILE ${folder}/tried
                OUTPUT_VARIABLE words)
    file(WRITE ${folder}/${kind}.log "${words}")
    if(tried)
      file(STRINGS ${folder}/tried found REGEX "grtx_systemc_version=")
      string(REGEX REPLACE ".*grtx_systemc_version=([0-9.]+).*" "\\1" found "${found}")
      if(kind STREQUAL "EXECUTABLE")
        set(links TRUE)
      endif()
      break()
    endif()
  endforeach()
  set(grtx_systemc_version ${found} PARENT_SCOPE)
  set(grtx_systemc_links ${links} PARENT_SCOPE)
endfunction()

# Finds the SC_CPLUSPLUS with which a program links.
function(grtx_choose_systemc library place)
  foreach(cplusplus 201703L 202002L)
    grtx_try_systemc(${library} ${cplusplus})
    if(grtx_systemc_links)
      set(GRTX_SC_CPLUSPLUS ${cplusplus} CACHE STRING "C++ version in the symbols of the SystemC library" FORCE)
      set(GRTX_SYSTEMC_VERSION ${grtx_systemc_version} CACHE INTERNAL "of the SystemC that the libraries are built with")
      set(GRTX_SYSTEMC_PLACE ${place} CACHE INTERNAL "where that SystemC was found")
      return()
    endif()
  endforeach()
  message(FATAL_ERROR "A program does not link with SystemC ${grtx_systemc_version} (${library} of ${place}): its library must "
                      "be built as C++17 or C++20. ${CMAKE_BINARY_DIR}/CMakeFiles/grtx_systemc holds the linker's words")
endfunction()

macro(grtx_find_for library)
  if("${library}" STREQUAL "base")
    grtx_find(fmt 9)
    grtx_find_modules(XXHASH "libxxhash>=0.8")
    if(NOT GRTX_INSTALLED)  # who includes json.h looks for it
      grtx_find(nlohmann_json 3.11)
    endif()
  elseif("${library}" STREQUAL "traces")
    grtx_find(Threads)
    grtx_find_modules(ZSTD "libzstd>=1.5")
  elseif("${library}" STREQUAL "frontend")
    # Embree 4 (Debian 13) or 3 (Debian 12): rtcBuildBVH is the same in both.
    find_package(embree 4 CONFIG QUIET)
    if(NOT embree_FOUND)
      grtx_find(embree 3.13)
    endif()
    grtx_find(glm 0.9.9)
    grtx_find(TBB 2021)
    grtx_find(PNG 1.6)
    grtx_find(OpenEXR 3.1)
    grtx_find(ZLIB 1.2)
    grtx_find_modules(WEBP "libwebp>=1.2")
    grtx_find_modules(ZIP "libzip>=1.7")
    grtx_find(nlohmann_json 3.11)
  elseif("${library}" STREQUAL "modules")
    grtx_find_systemc()
  elseif("${library}" STREQUAL "sim")
    grtx_find(tomlplusplus 3.3)
    grtx_find(nlohmann_json 3.11)
  elseif("${library}" STREQUAL "explore")
    grtx_find(SQLite3 3.40)
    grtx_find(Pagmo 2.18)
  elseif("${library}" STREQUAL "program")
    grtx_find(CLI11 2.1)
  endif()
endmacro()
