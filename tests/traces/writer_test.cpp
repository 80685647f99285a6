// SPDX-License-Identifier: Apache-2.0
// Writer: the same bytes for any threads and order, nothing under the final name before finish(), misuse is refused.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <future>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "grtx/base/atomic_file.h"
#include "grtx/base/error.h"
#include "grtx/traces/reader.h"
#include "grtx/traces/writer.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::traces {
namespace {

using testing::RandomOptions;
using testing::TemporaryFile;

bool exists(const std::string& path) {
  struct stat status {};
  return ::stat(path.c_str(), &status) == 0;
}

RandomOptions many_groups() {
  RandomOptions options{.groups = 60, .two_level = true};
  return options;
}

Header empty_groups(std::uint64_t count) {
  Header header;
  header.groups = count;
  return header;
}
RayGroup empty_group(std::uint32_t index) {
  RayGroup group;
  group.index = index;
  return group;
}

TEST(Writer, SameBytesFromThreadsInShuffledOrder) {
  const auto trace = testing::random_trace(many_groups());
  const testing::TraceFile in_order(trace.header, trace.groups);
  const std::string expected = read_file(in_order.path());
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::vector<std::size_t> order(trace.groups.size());
    std::iota(order.begin(), order.end(), 0U);
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    const TemporaryFile shuffled;
    Writer writer(shuffled.path(), trace.header);
    std::atomic<std::size_t> next{0};
    {
      std::vector<std::jthread> pool;
      for (int t = 0; t < 4; ++t) {
        pool.emplace_back([&] {
          for (std::size_t i = next++; i < order.size(); i = next++) writer.append(trace.groups[order[i]]);
        });
      }
    }
    writer.finish();
    EXPECT_TRUE(read_file(shuffled.path()) == expected) << "seed " << seed;
    EXPECT_EQ(writer.bytes(), expected.size());
  }
}

TEST(Writer, ReaderSeesItsTotalsAndBytes) {
  const auto trace = testing::random_trace(many_groups());
  const TemporaryFile file;
  Writer writer(file.path(), trace.header);
  for (const RayGroup& group : trace.groups) writer.append(group);
  writer.finish();
  const Reader reader(file.path());
  EXPECT_EQ(reader.totals(), writer.totals());
  EXPECT_EQ(reader.bytes(), writer.bytes());
  EXPECT_GT(reader.totals().visits(), 0U);
  EXPECT_GT(reader.totals().evictions, 0U);
  EXPECT_GT(reader.totals().checkpoints_read, 0U);
}

TEST(Writer, LeavesNothingWithoutFinish) {
  const auto trace = testing::random_trace(RandomOptions{});
  const TemporaryFile file;
  {
    Writer writer(file.path(), trace.header);
    writer.append(trace.groups[0]);
    EXPECT_FALSE(exists(file.path()));
  }
  EXPECT_FALSE(exists(file.path()));
  EXPECT_FALSE(exists(file.path() + ".partial." + std::to_string(::getpid())));
}

TEST(Writer, RefusesMissingRepeatedAndForeignGroups) {
  const TemporaryFile file;
  Writer writer(file.path(), empty_groups(3));
  writer.append(empty_group(0));
  writer.append(empty_group(2));
  EXPECT_THROW(writer.append(empty_group(0)), std::logic_error);
  EXPECT_THROW(writer.append(empty_group(2)), std::logic_error);
  EXPECT_THROW(writer.append(empty_group(3)), std::logic_error);
  EXPECT_THROW(writer.finish(), std::logic_error);
  writer.append(empty_group(1));
  writer.finish();
  EXPECT_THROW(writer.finish(), std::logic_error);
  EXPECT_THROW(writer.append(empty_group(1)), std::logic_error);
  EXPECT_EQ(Reader(file.path()).group_count(), 3U);
}

TEST(Writer, NamesAFolderThatIsMissing) {
  try {
    Writer writer("/nonexistent-folder/t.grtx", Header{});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.file(), "/nonexistent-folder/t.grtx");
  }
}

TEST(Writer, RefusesAHeaderThatAReaderWouldRefuse) {
  const TemporaryFile file;
  Header header;
  header.k = 0;
  EXPECT_THROW(Writer(file.path(), header), Error);
  header = Header{};
  header.tracing = Tracing::closest;  // with a k-buffer of 8
  EXPECT_THROW(Writer(file.path(), header), Error);
}

// Group 0 is missing, so 1025 chunks may not wait in memory: the caller of number 1025 does.
TEST(Writer, BlocksWhoIsTooFarAhead) {
  const TemporaryFile file;
  Writer writer(file.path(), empty_groups(1026));
  for (std::uint32_t i = 1; i <= 1024; ++i) writer.append(empty_group(i));
  auto last = std::async(std::launch::async, [&] { writer.append(empty_group(1025)); });
  EXPECT_EQ(last.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout);
  writer.append(empty_group(0));
  last.get();
  writer.finish();
  EXPECT_EQ(Reader(file.path()).group_count(), 1026U);
}

TEST(Writer, CancelWakesWhoWaits) {
  const TemporaryFile file;
  Writer writer(file.path(), empty_groups(5000));
  auto waiting = std::async(std::launch::async, [&] { writer.append(empty_group(4000)); });
  EXPECT_EQ(waiting.wait_for(std::chrono::milliseconds(20)), std::future_status::timeout);
  writer.cancel();
  EXPECT_THROW(waiting.get(), Error);
  EXPECT_THROW(writer.append(empty_group(0)), Error);
  EXPECT_THROW(writer.finish(), Error);
}

}  // namespace
}  // namespace grtx::traces
