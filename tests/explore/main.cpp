// SPDX-License-Identifier: Apache-2.0
// Entry point of the assembly tests: GoogleTest drives, SystemC is a library (its own main needs a sc_main to link).
#include <gtest/gtest.h>

#include <systemc>

int sc_main(int, char*[]) { return 0; }

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
