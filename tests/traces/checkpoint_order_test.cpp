// SPDX-License-Identifier: Apache-2.0
// The orders in which a replay round reads the source buffer, each alone.
#include "grtx/traces/orders/checkpoint_order.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace grtx::traces {
namespace {

struct Entry {
  float t;
  int number;  ///< in the order of writing
};

/// Numbers of the entries in the order in which they are read.
template <typename Policy>
std::vector<int> read_by(Policy, std::vector<Entry> source) {
  Policy::arrange(source);
  std::vector<int> numbers;
  for (std::size_t read = 0; read < source.size(); ++read) {
    numbers.push_back(source[Policy::position(read, source.size())].number);
  }
  return numbers;
}

const std::vector<Entry> kWritten = {{3.0f, 0}, {1.0f, 1}, {2.0f, 2}, {1.0f, 3}, {0.5f, 4}};

TEST(CheckpointOrder, FifoReadsAsWritten) {
  EXPECT_EQ(read_by(Fifo{}, kWritten), (std::vector<int>{0, 1, 2, 3, 4}));
  EXPECT_TRUE(Fifo::kByPlace);
  EXPECT_FALSE(Fifo::kBackwards);
}

TEST(CheckpointOrder, LifoReadsFromTheEnd) {
  EXPECT_EQ(read_by(Lifo{}, kWritten), (std::vector<int>{4, 3, 2, 1, 0}));
  EXPECT_TRUE(Lifo::kByPlace);
  EXPECT_TRUE(Lifo::kBackwards);
}

TEST(CheckpointOrder, NearestReadsByDistanceThenAsWritten) {
  EXPECT_EQ(read_by(Nearest{}, kWritten), (std::vector<int>{4, 1, 3, 2, 0}));
  EXPECT_FALSE(Nearest::kByPlace) << "a trace, which holds no t, must name the entries";
  EXPECT_FALSE(Nearest::kBackwards);
}

TEST(CheckpointOrder, EachNameHasItsPolicy) {
  std::set<CheckpointOrder> seen;
  for (const auto& entry : enum_names(CheckpointOrder{})) {
    with_checkpoint_order(entry.value, [&]<typename Policy>(Policy) {
      EXPECT_EQ(Policy::kName, entry.value) << entry.name;
      seen.insert(Policy::kName);
      const ReadOrder order(entry.value);
      EXPECT_EQ(order.by_place(), Policy::kByPlace);
      EXPECT_EQ(order.backwards(), Policy::kBackwards);
      for (std::size_t read = 0; read < 9; ++read) EXPECT_EQ(order.position(read, 9), Policy::position(read, 9));
    });
  }
  EXPECT_EQ(seen.size(), enum_names(CheckpointOrder{}).size());
}

}  // namespace
}  // namespace grtx::traces
