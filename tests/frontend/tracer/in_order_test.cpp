// SPDX-License-Identifier: Apache-2.0
#include "grtx/frontend/tracer/in_order.h"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace grtx::frontend {
namespace {

TEST(ForEachInOrder, NoIndexRunsAheadOfOneThatNobodyHasTaken) {
  constexpr std::size_t kCount = 400;
  for (const unsigned threads : {1u, 2u, 7u}) {
    std::vector<std::atomic<unsigned>> calls(kCount);
    std::atomic<std::size_t> started{0}, too_early{0};
    for_each_in_order(kCount, threads, [&](std::size_t i) {
      // All indices below have been taken; at most as many as there are other threads have not started yet.
      if (i > started++ + threads - 1) ++too_early;
      ++calls[i];
      std::this_thread::sleep_for(std::chrono::microseconds(50));
    });
    EXPECT_EQ(too_early, 0u) << threads << " threads";
    for (std::size_t i = 0; i < kCount; ++i) ASSERT_EQ(calls[i], 1u) << i;
  }
}

TEST(ForEachInOrder, StopsAtAFailure) {
  for (const unsigned threads : {1u, 2u, 7u}) {
    std::atomic<std::size_t> calls{0};
    EXPECT_THROW(for_each_in_order(100000, threads,
                                   [&](std::size_t i) {
                                     ++calls;
                                     if (i == 100) throw std::runtime_error("hundred");
                                     std::this_thread::sleep_for(std::chrono::microseconds(50));
                                   }),
                 std::runtime_error);
    EXPECT_LT(calls, 1000u) << threads << " threads";
  }
}

TEST(ForEachInOrder, TakesNothingOfNothing) {
  for_each_in_order(0, 2, [](std::size_t) { FAIL(); });
}

}  // namespace
}  // namespace grtx::frontend
