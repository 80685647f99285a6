// SPDX-License-Identifier: Apache-2.0
// Records reach the writer all and in order, whatever the number of blocks; what the writer throws reaches the
// producer.
#include "grtx/rtl_tlm/observe/block_writer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

namespace grtx::sim {
namespace {

constexpr std::uint64_t kMany = 1'000'003;  // more blocks than may wait, and a broken one

TEST(BlockWriter, WritesAllInOrder) {
  std::vector<std::uint64_t> written;
  {
    BlockWriter<std::uint64_t> writer([&](const std::vector<std::uint64_t>& block) {
      EXPECT_FALSE(block.empty());
      written.insert(written.end(), block.begin(), block.end());
    });
    for (std::uint64_t i = 0; i < kMany; ++i) writer.push(i);
    writer.finish();
    ASSERT_EQ(written.size(), kMany);
  }
  for (std::uint64_t i = 0; i < kMany; ++i) ASSERT_EQ(written[i], i);
}

TEST(BlockWriter, NothingToWriteIsNoBlock) {
  unsigned calls = 0;
  {
    BlockWriter<int> writer([&](const std::vector<int>&) { ++calls; });
    writer.finish();
  }
  EXPECT_EQ(calls, 0U);
}

TEST(BlockWriter, TheWritersExceptionReachesTheProducer) {
  const auto full = [](const std::vector<std::uint64_t>&) { throw std::runtime_error("disk full"); };
  BlockWriter<std::uint64_t> at_the_end(full);
  at_the_end.push(1);
  EXPECT_THROW(at_the_end.finish(), std::runtime_error);
  BlockWriter<std::uint64_t> on_the_way(full);
  EXPECT_THROW(
      {
        for (std::uint64_t i = 0; i < 100 * kMany; ++i) on_the_way.push(i);
      },
      std::runtime_error);
}

TEST(BlockWriter, EndsWithoutFinish) {
  std::uint64_t written = 0;
  {
    BlockWriter<std::uint64_t> writer([&](const std::vector<std::uint64_t>& block) { written += block.size(); });
    for (std::uint64_t i = 0; i < kMany; ++i) writer.push(i);
  }
  EXPECT_LE(written, kMany);  // what still waited is dropped
}

}  // namespace
}  // namespace grtx::sim
