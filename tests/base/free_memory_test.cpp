// SPDX-License-Identifier: Apache-2.0
// What memory is free is asked before much of it is taken.
#include "grtx/base/free_memory.h"

#include <gtest/gtest.h>

#include "error_of.h"
#include "grtx/base/error.h"
#include "limited_memory.h"

namespace grtx {
namespace {

TEST(FreeMemory, IsWhatTheProcessMayStillTake) {
  if (!free_memory()) GTEST_SKIP() << "the system does not say";
  const test::LimitedMemory limit(std::uint64_t{64} << 20);
  EXPECT_LE(*free_memory(), std::uint64_t{64} << 20);
  EXPECT_EQ(memory_fault(std::uint64_t{16} << 20), "");
  EXPECT_EQ(test::error_of([] { require_memory(std::uint64_t{3} << 30, "f", "header"); }).substr(0, 41),
            "f: header: takes 3221 MB more memory, and");
}

}  // namespace
}  // namespace grtx
