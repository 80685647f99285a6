// SPDX-License-Identifier: Apache-2.0
// Entry point of the tests of experiment/: GoogleTest drives, SystemC is a library (its own main needs a sc_main to
// link). Machines by name are those of the checkout.
#include <gtest/gtest.h>

#include <systemc>

#include "grtx/experiment/machine.h"
#include "paths.h"

int sc_main(int, char*[]) { return 0; }

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  grtx::experiment::set_machines_folder(grtx::paths::source_dir() + "/configs/machines");
  return RUN_ALL_TESTS();
}
