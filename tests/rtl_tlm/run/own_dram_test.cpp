// SPDX-License-Identifier: Apache-2.0
// The example of docs/model/gpu.md: another DRAM model behind the TLM-2.0 sockets of the GPU.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "grtx/base/atomic_file.h"
#include "paths.h"
#include "traces/random_group.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

struct Outcome {
  int code = -1;
  std::string out;
};

Outcome own_dram(const std::string& arguments) {
  const std::string command = "'" + grtx::paths::own_dram() + "' " + arguments + " 2>&1";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  Outcome outcome;
  std::array<char, 256> buffer{};
  while (std::fgets(buffer.data(), static_cast<int>(buffer.size()), pipe) != nullptr) outcome.out += buffer.data();
  const int status = ::pclose(pipe);
  if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
  return outcome;
}

struct Result {
  unsigned long cycles = 0, reads = 0, writes = 0;
};

Result result_of(const Outcome& outcome) {
  Result r;
  EXPECT_EQ(outcome.code, 0) << outcome.out;
  EXPECT_EQ(
      std::sscanf(outcome.out.c_str(), "%lu cycles, %lu DRAM reads, %lu DRAM writes", &r.cycles, &r.reads, &r.writes),
      3)
      << outcome.out;
  return r;
}

class OwnDram : public ::testing::Test {
 protected:
  OwnDram() : file_("own_dram") {
    traces::testing::RandomOptions options{.seed = 3, .groups = 12, .warp_size = 32};
    const auto trace = traces::testing::random_trace(options);
    traces::testing::write_trace(file_.path(), trace.header, trace.groups);
  }
  traces::testing::TemporaryFile file_;
};

TEST_F(OwnDram, TakesThePlaceOfTheBuiltInModel) {
  const Result fast = result_of(own_dram(file_.path() + " 40"));
  const Result slow = result_of(own_dram(file_.path() + " 400"));
  const Result narrow = result_of(own_dram(file_.path() + " 40 1"));
  EXPECT_GT(fast.reads, 0U);
  // What is read does not depend on time; a ray that misses waits for at least one access longer.
  EXPECT_GE(slow.cycles, fast.cycles + static_cast<unsigned long>(360 * 1.365));
  EXPECT_GT(narrow.cycles, fast.cycles);
  EXPECT_EQ(result_of(own_dram(file_.path() + " 40")).cycles, fast.cycles);
}

TEST_F(OwnDram, ANarrowBusIsTheLargestBoundAndTheWaveformShowsTheChannel) {
  const std::string waves = file_.path() + ".vcd";
  const Outcome outcome = own_dram(file_.path() + " 40 0.05 " + waves);
  const Result r = result_of(outcome);
  const std::size_t at = outcome.out.find("bound ");
  ASSERT_NE(at, std::string::npos) << outcome.out;
  const auto bound = static_cast<double>(std::stoul(outcome.out.substr(at + 6)));
  // 32 B take 640 ns, 873.6 cycles, on the busier of two channels.
  EXPECT_GE(bound, static_cast<double>(r.reads) / 2 * 873.0);
  EXPECT_LE(bound, static_cast<double>(r.cycles));
  const std::string text = read_file(waves);
  EXPECT_NE(text.find("inside"), std::string::npos);
  std::filesystem::remove(waves);
  std::filesystem::remove(file_.path() + ".gtkw");
}

TEST_F(OwnDram, RefusesBadArguments) {
  EXPECT_EQ(own_dram("").code, 2);
  EXPECT_EQ(own_dram(file_.path() + " quick").code, 2);
  EXPECT_EQ(own_dram(file_.path() + ".missing").code, 2);
}

}  // namespace
}  // namespace grtx::sim
