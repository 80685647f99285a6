# SPDX-License-Identifier: Apache-2.0
# A SystemC of another version: the system's library, and a header that says so.
set(systemc_header ${CMAKE_BINARY_DIR}/other_systemc)
file(WRITE ${systemc_header}/systemc
     "#define SC_VERSION_MAJOR 9\n#define SC_VERSION_MINOR 8\n#define SC_VERSION_PATCH 7\n")
find_library(systemc_library systemc REQUIRED)
if(NOT TARGET SystemC::systemc)
  add_library(SystemC::systemc UNKNOWN IMPORTED)
  set_target_properties(SystemC::systemc PROPERTIES IMPORTED_LOCATION ${systemc_library}
                        INTERFACE_INCLUDE_DIRECTORIES ${systemc_header})
endif()
