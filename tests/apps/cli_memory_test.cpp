// SPDX-License-Identifier: Apache-2.0
// What the program says when there is no memory.
#include <gmock/gmock.h>

#include "apps/program.h"

namespace grtx::e2e {
namespace {

using ::testing::HasSubstr;

class CliMemory : public ::testing::Test {
 protected:
  /// With so many KiB of address space.
  Outcome run_within(unsigned kib, const std::string& arguments) const {
    const std::string command = "cd '" + folder_.path("") + "' && ulimit -v " + std::to_string(kib) + " && '" +
                                grtx::paths::program() + "' " + arguments + " >.stdout 2>.stderr";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, folder_.read(".stdout"), folder_.read(".stderr")};
  }

  Folder folder_;
};

// A library that allocates as it is loaded threw before main had begun.
TEST_F(CliMemory, WithoutMemoryTheVersionEndsInOneLine) {
  for (unsigned kib = 80'000; kib <= 180'000; kib += 10'000) {
    const Outcome outcome = run_within(kib, "--version");
    if (outcome.code == 0) continue;
    if (outcome.code == 127) continue;  // the loader itself found none
    EXPECT_EQ(outcome.code, 3) << kib << ": " << outcome.err;
    EXPECT_EQ(outcome.err, "grtx: internal error: out of memory\n") << kib;
  }
}

TEST_F(CliMemory, AStructureWithoutMemorySaysWhatItIs) {
  ASSERT_EQ(folder_.run("synth --preset object --count 100000 --seed 1 --sh-degree 0 --quiet -o s.ply").code, 0);
  const Outcome outcome =
      run_within(500'000,
                 "trace --scene s.ply --cameras s.cameras.json --width 8 --height 8 --accel tri20 --threads 1 "
                 "--no-trace --image i.png --quiet");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_TRUE(is_one_error_line(outcome.err)) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("out of memory: a structure tri20 of 100000 Gaussians takes some 0.2 GB; --accel "
                                     "tlas-tri20 takes 0.033 GB"));
}

}  // namespace
}  // namespace grtx::e2e
