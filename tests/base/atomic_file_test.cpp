// A file appears under its final name only when it was committed.
#include "grtx/base/atomic_file.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>

#include "grtx/base/error.h"

namespace {

std::size_t files_in(const std::filesystem::path& folder) {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

struct AtomicFileTest : testing::Test {
  AtomicFileTest() { std::filesystem::create_directories(folder); }
  ~AtomicFileTest() override { std::filesystem::remove_all(folder); }
  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("atomic_file_" + std::to_string(::getpid()));
};

TEST_F(AtomicFileTest, LeavesNothingWithoutCommit) {
  { grtx::AtomicFile(folder / "a").write("half"); }
  EXPECT_EQ(files_in(folder), 0u);
}

TEST_F(AtomicFileTest, KeepsTheOldFileWithoutCommit) {
  grtx::write_file(folder / "a", "old");
  { grtx::AtomicFile(folder / "a").write("new"); }
  EXPECT_EQ(grtx::read_file(folder / "a"), "old");
}

TEST_F(AtomicFileTest, ReplacesOnCommit) {
  grtx::write_file(folder / "a", "old");
  grtx::write_file(folder / "a", "new");
  EXPECT_EQ(grtx::read_file(folder / "a"), "new");
  EXPECT_EQ(files_in(folder), 1u);
}

TEST_F(AtomicFileTest, MissingFolderIsAnError) {
  EXPECT_THROW(grtx::write_file(folder / "missing" / "a", "x"), grtx::Error);
}

}  // namespace
