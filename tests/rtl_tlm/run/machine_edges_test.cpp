// SPDX-License-Identifier: Apache-2.0
// Machines at the ends of their keys' ranges, each of which went wrong once: a run ends with every law and bound
// held, or is refused. scripts/fuzz_machines.py looks for more.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "grtx/base/child_process.h"
#include "grtx/base/error.h"
#include "rtl_tlm/simulate_priced.h"
#include "rtl_tlm/tiny_trace.h"
#include "traces/temporary_file.h"

namespace grtx::sim {
namespace {

using ::testing::HasSubstr;

class MachineEdges : public ::testing::Test {
 protected:
  MachineEdges() { test::write_tiny_trace(trace_.path(), {6, 32}); }

  /// What a run says: its cycles, or what is wrong.
  std::string run(const std::vector<std::string>& settings) const {
    ChildProcess child("simulation", [&] {
      const SimulationResult result = test::simulate_priced(trace_.path(), load_config("", settings));
      std::string text = result.cycles > 0 ? "cycles" : "no cycles";
      for (const std::string& violation : result.violations) text += "\n" + violation;
      return text;
    });
    try {
      return child.result();
    } catch (const std::exception& error) {
      return error.what();
    }
  }
  void runs(const std::vector<std::string>& settings) const {
    EXPECT_EQ(run(settings), "cycles") << ::testing::PrintToString(settings);
  }

  const traces::testing::TemporaryFile trace_{"edges"};
};

TEST_F(MachineEdges, ActivatesMayHaveNoDistance) { runs({"dram.timing.rrd=0"}); }

TEST_F(MachineEdges, TheLastTestOfASlowUnitKeepsTheLowerBound) {
  for (const char* unit : {"rt.box", "rt.triangle"}) {
    for (const char* interval : {"2", "3000", "10000"}) {
      runs({std::string(unit) + ".interval=" + interval, std::string(unit) + ".count=1"});
    }
  }
  runs({"rt.box.interval=3000", "rt.box.per_child=true"});
}

TEST_F(MachineEdges, BurstsAfterTheEndKeepTheLowerBound) {
  runs({"dram.timing.ccd=10000"});
  runs({"dram.timing.ccd=10000", "l2.slices=1", "l2.bytes=8192", "l1.bytes=32768"});
}

TEST_F(MachineEdges, ALongPhaseOfAShaderIsNoDeadlock) { runs({"simt.cost.sh_per_coefficient=571160"}); }

TEST_F(MachineEdges, ASlowMemoryIsNoDeadlock) { runs({"dram.fixed_latency=5300000"}); }

TEST_F(MachineEdges, AQueueThatHoldsNoSectorIsRefused) {
  EXPECT_THROW(load_config("", {"dram.burst_bytes=1"}), Error);
  runs({"dram.burst_bytes=8", "dram.queue=4"});  // a sector fills the queue
}

TEST_F(MachineEdges, TablesThatMultiplyToGigabytesAreRefused) {
  EXPECT_THAT(run({"l2.bytes=1000000000000"}), HasSubstr("must be 32 to 1073741824"));
  EXPECT_THAT(run({"l2.bytes=1073741824", "l2.line_bytes=32", "l2.ways=1"}), HasSubstr("l2.bytes: would take 4.3 GB"));
  EXPECT_THAT(run({"gpu.sms=256", "l1.mshr_entries=4096", "l1.mshr_merges=1024"}),
              HasSubstr("l1.mshr_entries: would take"));
}

}  // namespace
}  // namespace grtx::sim
