# SPDX-License-Identifier: Apache-2.0
# For projects that ask for SystemC by its own package name where the distribution ships none, as Debian does: DRAMSys,
# for one, is then configured with -DCMAKE_MODULE_PATH=<this folder> (docs/guide/dram-backends.md).
find_package(PkgConfig REQUIRED)
pkg_check_modules(SYSTEMC REQUIRED IMPORTED_TARGET systemc>=2.3.3 tlm)
if(NOT TARGET SystemC::systemc)
  add_library(SystemC::systemc INTERFACE IMPORTED GLOBAL)
  target_link_libraries(SystemC::systemc INTERFACE PkgConfig::SYSTEMC)
endif()
set(SystemCLanguage_FOUND TRUE)
