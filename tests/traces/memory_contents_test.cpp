// SPDX-License-Identifier: Apache-2.0
// Files of memory contents: what is written is read, and what is damaged is refused by name.
#include "grtx/traces/memory_contents.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "error_of.h"
#include "grtx/base/atomic_file.h"
#include "grtx/base/hash.h"
#include "traces/temporary_file.h"

namespace grtx::traces {
namespace {

using testing::TemporaryFile;

std::string nodes() {
  std::string bytes;
  for (int i = 0; i < 3000; ++i) bytes.push_back(static_cast<char>(i * 7));
  return bytes;
}

std::string written(const TemporaryFile& file) {
  write_memory_contents(file.path(), "cafe", {{kNodeImageRegion, nodes()}, {kPixelRegion, "0123456789abcdef"}});
  return read_file(file.path());
}

/// With the hash of the changed bytes.
std::string signed_again(std::string bytes) {
  bytes.resize(bytes.size() - 8);
  const std::uint64_t hash = xxh3(bytes);
  for (unsigned i = 0; i < 8; ++i) bytes.push_back(static_cast<char>(hash >> 8 * i & 0xFF));
  return bytes;
}

std::string error_of(const TemporaryFile& file, const std::string& bytes) {
  write_file(file.path(), bytes);
  return test::error_of([&] { MemoryContents contents(file.path()); });
}

TEST(MemoryContents, HoldWhatWasWritten) {
  const TemporaryFile file("contents");
  written(file);
  MemoryContents moved(file.path());
  const MemoryContents contents = std::move(moved);
  EXPECT_EQ(contents.trace(), "cafe");
  ASSERT_EQ(contents.regions().size(), 2u);
  EXPECT_EQ(contents.region(kNodeImageRegion), nodes());
  EXPECT_EQ(contents.region(kPixelRegion), "0123456789abcdef");
  EXPECT_EQ(contents.region(kShRegion), "");
}

TEST(MemoryContents, RefuseEachDamagedByteAndEachShorterFile) {
  const TemporaryFile file("contents");
  const std::string bytes = written(file);
  for (std::size_t at = 0; at < bytes.size(); at += at < 200 ? 1 : 97) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 4);
    EXPECT_NE(error_of(file, damaged), "") << at;
    EXPECT_NE(error_of(file, bytes.substr(0, at)), "") << at;
  }
}

TEST(MemoryContents, SayWhatIsWrong) {
  const TemporaryFile file("contents");
  const std::string bytes = written(file);
  EXPECT_THAT(error_of(file, "GRTX"), ::testing::HasSubstr("this is no file of memory contents"));
  EXPECT_THAT(error_of(file, bytes + "x"), ::testing::HasSubstr("the hash is not that of the file"));
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string changed = bytes;
    changed.replace(changed.find(from), from.size(), to);
    return error_of(file, signed_again(changed));
  };
  EXPECT_THAT(with(":3000", ":2999"), ::testing::HasSubstr("regions: must fill the file"));
  EXPECT_THAT(with(":3000", ":9999"), ::testing::HasSubstr("node_image: must end before the file"));
  EXPECT_THAT(with("\"trace\"", "\"other\""), ::testing::HasSubstr("must be an object with trace"));
  write_memory_contents(file.path(), "cafe", {{kShRegion, ""}, {kShRegion, ""}});
  EXPECT_THAT(error_of(file, read_file(file.path())), ::testing::HasSubstr("sh: is there twice"));
  EXPECT_THAT(with(":3000", ":-300"), ::testing::HasSubstr("node_image: must end before the file"));
}

}  // namespace
}  // namespace grtx::traces
