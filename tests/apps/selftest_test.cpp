// SPDX-License-Identifier: Apache-2.0
// grtx selftest: OK with each path of vector instructions, and one line where it cannot work.
#include <gtest/gtest.h>

#include "apps/program.h"

namespace grtx::e2e {
namespace {

TEST(Selftest, IsOkWithoutVectorInstructions) {
  const Folder folder;
  ::setenv("GRTX_SIMD", "portable", 1);
  const Outcome outcome = folder.run("selftest");
  ::unsetenv("GRTX_SIMD");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_TRUE(outcome.out.ends_with("\nOK\n")) << outcome.out;
}

// A comma for the decimal point, another clock, one core, memory that is not zero, no wide vectors in the C library,
// and the second path of vector instructions.
TEST(Selftest, IsOkWhateverTheEnvironmentSays) {
  const Folder folder;
  const std::string locale = folder.path("de_DE.UTF-8");
  std::string environment =
      "GRTX_SIMD=avx2 TZ=Asia/Kathmandu MALLOC_PERTURB_=165 MALLOC_ARENA_MAX=1 COLUMNS=20 "
      "GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX512F,-AVX2_Usable,-AVX2,-AVX_Usable,-ERMS ";
  if (std::system(("localedef -i de_DE -f UTF-8 '" + locale + "' >/dev/null 2>&1").c_str()) == 0) {
    environment += "LOCPATH='" + folder.path("") + "' LC_ALL=de_DE.UTF-8 ";
  }
  const std::string program = std::system("taskset -c 0 true 2>/dev/null") == 0 ? "taskset -c 0 " : "";
  const std::string command = "cd '" + folder.path("") + "' && " + environment + program + "'" +
                              grtx::paths::program() + "' selftest > out 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << folder.read("out");
  EXPECT_TRUE(folder.read("out").ends_with("\nOK\n")) << folder.read("out");
}

TEST(Selftest, PrintsWhatItCompares) {
  const Folder folder;
  const Outcome outcome = folder.run("selftest --print");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  for (const char* text : {"synth:\nscene ", "trace:\nimage ", "cycle:\nbaseline "}) {
    EXPECT_NE(outcome.out.find(text), std::string::npos) << outcome.out;
  }
}

TEST(Selftest, WithoutATemporaryFolderIsOneLine) {
  const Folder folder;
  ::setenv("TMPDIR", folder.path("none").c_str(), 1);
  const Outcome outcome = folder.run("selftest");
  ::unsetenv("TMPDIR");
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.err.find('\n'), outcome.err.size() - 1) << outcome.err;
  EXPECT_NE(outcome.err.find("temporary folder"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace grtx::e2e
