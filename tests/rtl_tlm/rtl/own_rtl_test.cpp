// SPDX-License-Identifier: Apache-2.0
// The example of docs/guide/own-rtl.md: a ray-box unit of a user's in SystemVerilog.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

#include "paths.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

std::string printed_by_own_rtl(const std::string& arguments) {
  const std::string command = "'" + paths::own_rtl() + "' " + arguments + " 2>&1";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  std::string out;
  std::array<char, 256> buffer{};
  while (std::fgets(buffer.data(), static_cast<int>(buffer.size()), pipe) != nullptr) out += buffer.data();
  EXPECT_EQ(::pclose(pipe), 0) << out;
  return out;
}

TEST(OwnRtl, ABoxUnitOfTheUsersInVerilogTakesTheCyclesOfOursOfItsSize) {
  if (paths::own_rtl().empty()) GTEST_SKIP() << "no Verilator when this was built";
  traces::testing::TemporaryFile file("own_rtl");
  traces::testing::RandomOptions options{.seed = 3, .groups = 12, .warp_size = 32};
  const auto trace = traces::testing::random_trace(options);
  traces::testing::write_trace(file.path(), trace.header, trace.groups);
  const std::string rtl = printed_by_own_rtl(file.path());
  EXPECT_EQ(rtl, printed_by_own_rtl(file.path() + " tlm"));
  EXPECT_NE(rtl.find(" box operations"), std::string::npos) << rtl;
}

}  // namespace
}  // namespace grtx::sim
