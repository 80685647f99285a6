# SPDX-License-Identifier: Apache-2.0
# A SystemC of another version: the system's library, and a header that says so.
find_library(systemc_library systemc REQUIRED)
if(NOT TARGET SystemC::systemc)
  add_library(SystemC::systemc UNKNOWN IMPORTED)
  set_target_properties(SystemC::systemc PROPERTIES IMPORTED_LOCATION ${systemc_library}
                        INTERFACE_INCLUDE_DIRECTORIES ${CMAKE_CURRENT_LIST_DIR}/include)
endif()
