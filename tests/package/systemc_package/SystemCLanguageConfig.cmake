# SPDX-License-Identifier: Apache-2.0
# The system's SystemC, as the CMake package that Accellera's own build installs and Debian leaves out.
find_path(systemc_include systemc REQUIRED)
find_library(systemc_library systemc REQUIRED)
if(NOT TARGET SystemC::systemc)
  add_library(SystemC::systemc UNKNOWN IMPORTED)
  set_target_properties(SystemC::systemc PROPERTIES IMPORTED_LOCATION ${systemc_library}
                                                    INTERFACE_INCLUDE_DIRECTORIES ${systemc_include})
endif()
