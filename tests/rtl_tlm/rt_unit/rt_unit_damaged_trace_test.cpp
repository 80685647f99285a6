// SPDX-License-Identifier: Apache-2.0
// A trace that contradicts itself ends the run with a report of the input, which says where in the trace.
#include <gtest/gtest.h>

#include "grtx/modules/kernel/unit_fault.h"
#include "rtl_tlm/rt_unit/rt_bench.h"

namespace grtx::sim {
namespace {

using namespace test;

class RtUnitDamagedTrace : public modules::SystemCTest {};

// It was a runtime_error without a place, which the kernel reported as its own.
TEST_F(RtUnitDamagedTrace, ANodeOfTwoKindsIsAnErrorOfTheTrace) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP()
      << "an exception that crosses SystemC's stacks is a false report (github.com/google/sanitizers, issue 189)";
#endif
  traces::RayGroup group;
  group.index = 7;
  group.nodes = {node_definition(1, 10, {NodeKind::internal}), node_definition(10, 20, {NodeKind::triangle})};
  group.rays.resize(2);
  add_round(group.rays[0], {internal_event(0, 0b1), internal_event(1, 0b1), leaf_event(20, LeafOutcome::miss)});
  add_round(group.rays[1], {internal_event(0, 0b1), leaf_event(10, LeafOutcome::miss)});
  RtBench bench(small_header(), {});
  try {
    bench.run(group);
    ADD_FAILURE() << "the trace was taken";
  } catch (const sc_core::sc_report& report) {
    EXPECT_STREQ(report.get_msg_type(), modules::kInputReport);
    EXPECT_STREQ(report.get_msg(), "trace: group 7 lane 1 round 0: the node at byte 640 is of two kinds");
  }
}

}  // namespace
}  // namespace grtx::sim
