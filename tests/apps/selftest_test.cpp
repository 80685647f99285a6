// grtx selftest: OK with each path of vector instructions, and one line where it cannot work.
#include <gtest/gtest.h>

#include "apps/program.h"

namespace grtx::e2e {
namespace {

TEST(Selftest, IsOkWithEachVectorPath) {
  const Folder folder;
  for (const std::string path : {"portable", "avx2"}) {
    ::setenv("GRTX_SIMD", path.c_str(), 1);
    const Outcome outcome = folder.run("selftest");
    ::unsetenv("GRTX_SIMD");
    EXPECT_EQ(outcome.code, 0) << path << "\n" << outcome.out << outcome.err;
    EXPECT_TRUE(outcome.out.ends_with("\nOK\n")) << outcome.out;
  }
}

TEST(Selftest, PrintsWhatItCompares) {
  const Folder folder;
  const Outcome outcome = folder.run("selftest --print");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  for (const char* text : {"synth:\nscene ", "trace:\nimage ", "cycle:\nbaseline ", "fast:\nbaseline "}) {
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
