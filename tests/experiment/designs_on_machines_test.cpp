// SPDX-License-Identifier: Apache-2.0
// Which designs a run compares, and how their own keys lie over a machine's and below the user's.
#include <gmock/gmock.h>

#include "error_of.h"
#include "grtx/experiment/design_comparison.h"
#include "grtx/experiment/machine.h"
#include "grtx/experiment/machine_notes.h"
#include "temporary_folder.h"

namespace grtx::experiment {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(DesignComparison, IsOfAllUnlessNamesAreGiven) {
  EXPECT_THAT(DesignComparison({}, false).names(), ElementsAre("baseline", "sw", "hw", "grtx", "gautracer", "walk"));
  const DesignComparison named({"gautracer", "grtx", "walk"}, false);
  EXPECT_THAT(named.names(), ElementsAre("grtx", "gautracer", "walk"));
  EXPECT_EQ(named.reference(), "grtx");
  EXPECT_EQ(named.others().size(), 2U);
}

TEST(DesignComparison, TracesDesignsOfOneStructureOneAfterTheOther) {
  const DesignComparison all({}, false);
  std::vector<frontend::AccelKind> kinds;
  for (const ComparedDesign& design : all.designs()) kinds.push_back(design.kind);
  EXPECT_TRUE(std::is_sorted(kinds.begin(), kinds.end()));
  EXPECT_EQ(all.designs().size(), all.names().size());
}

// walk was in no run without --designs, since some options are none of it.
TEST(DesignComparison, LeavesOutADesignThatRefusesAnOptionUnlessItWasNamed) {
  const auto check = [](const ComparedDesign& design) {
    if (design.checkpoint || design.name == "baseline") throw Error("--tracing", design.name, "has no rounds");
  };
  const DesignComparison all({}, false, check);
  EXPECT_THAT(all.names(), ElementsAre("sw", "gautracer", "walk"));
  EXPECT_EQ(all.left_out(), (std::map<std::string, std::string>{{"baseline", "--tracing: baseline: has no rounds"},
                                                                {"grtx", "--tracing: grtx: has no rounds"},
                                                                {"hw", "--tracing: hw: has no rounds"}}));
  EXPECT_THAT(DesignComparison({"grtx", "walk"}, false, check).names(), ElementsAre("grtx", "walk"));
  EXPECT_EQ(test::error_of([] {
              DesignComparison({}, false, [](const ComparedDesign& d) { throw Error("--k", d.name, "is bad"); });
            }),
            "--k: baseline: is bad");
}

TEST(DesignComparison, OfSeveralObjectsTakesTwoLevels) {
  EXPECT_THAT(DesignComparison({}, true).names(), ElementsAre("sw", "grtx"));
  EXPECT_THAT(DesignComparison({"baseline", "grtx"}, true).names(), ElementsAre("grtx"));
  EXPECT_THAT(test::error_of([] { DesignComparison({"hw"}, true); }), HasSubstr("they need two levels"));
  EXPECT_THAT(test::error_of([] { DesignComparison({"gautracr"}, false); }), HasSubstr("the nearest is 'gautracer'"));
}

// It was refused: "rt.traversal: warp needs rt.warp_buffer.spill": the design brings it.
TEST(DesignOnAMachine, WalkRunsOnMachinesWithoutSpills) {
  EXPECT_FALSE(choose_machine({.machine = "rdna4-share"}).config.rt.warp_buffer.spill);
  for (const char* machine : {"paper", "rdna4-share", "ada"}) {
    const sim::GpuConfig walk = choose_machine({.machine = machine, .design = "walk"}).config;
    EXPECT_TRUE(walk.rt.warp_buffer.spill) << machine;
    EXPECT_EQ(walk.rt.traversal, modules::TraversalWay::warp) << machine;
    EXPECT_EQ(walk.rt.warp_stack.entries, 96U) << machine;
    EXPECT_EQ(walk.rt.warp_stack.ahead, 16U) << machine;
  }
}

// It was refused: "simt.payload_registers: needs simt.registers_per_thread", which the design brings.
TEST(DesignOnAMachine, AKeyThatNeedsTheDesignsOwnIsTakenBesideIt) {
  const MachineChoice set{.design = "gautracer", .settings = {"simt.payload_registers=60"}};
  EXPECT_EQ(choose_machine(set).config.simt.register_file.payload_registers, 60U);
  EXPECT_EQ(choose_machine({.design = "gautracer"}).config.simt.register_file.payload_registers,
            144U);  // 3 x k, k = 48
  EXPECT_EQ(choose_machine({.design = "gautracer", .k = 8}).config.simt.register_file.payload_registers, 24U);
  EXPECT_THAT(test::error_of([] { choose_machine({.settings = {"simt.payload_registers=60"}}); }),
              HasSubstr("simt.payload_registers: needs simt.registers_per_thread"));
}

TEST(DesignOfATrace, IsToldByStructureTraversalAndLayout) {
  std::map<std::string, std::string> inputs = {{"accel", "ellipsoid"}, {"checkpoint", "off"}};
  EXPECT_EQ(design_with_units(inputs), "gautracer");
  inputs["ahead"] = "16";
  EXPECT_EQ(design_with_units(inputs), "");  // walk has leaves of 32 B
  inputs["layout"] = "quantised";
  EXPECT_EQ(design_with_units(inputs), "walk");
  EXPECT_EQ(design_with_units({{"accel", "tri20"}, {"checkpoint", "off"}}), "");  // baseline has no units of its own
  EXPECT_THAT(test::error_of([&] { check_design("t.grtx", "header", inputs, explore::design_of("gautracer")); }),
              HasSubstr("t.grtx: header: is not of design gautracer: "));
}

}  // namespace
}  // namespace grtx::experiment
