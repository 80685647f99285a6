// SPDX-License-Identifier: Apache-2.0
// The alternatives that a configuration can choose, each on a hand-written trace with the total computed by hand.
#include "rtl_tlm/rt_unit/directed.h"

namespace grtx::sim {
namespace {

using namespace test;

Directed pointer_chase(unsigned length) {
  Directed d = directed(8, 1);
  add_round(d.groups[0].rays[0], chain(d.groups[0], length, LeafOutcome::miss));
  return d;
}

// The shader cores fetch: a cycle to the message, the link, the sectors one per cycle, the instructions of a traversal
// step, the link back; then the unit as ever.
TEST(DirectedAlternatives, NodeFetchByShaderCores) {
  for (const Cycle instructions : {Cycle{24}, Cycle{0}, Cycle{100}}) {
    const auto shader_visit = [&](Cycle unit) {
      return 1 + kMessage + (kNodeSectors - 1) + kL1Hit + phase(instructions) + kMessage + 1 + unit;
    };
    const ordered_json stats = simulated(pointer_chase(5), {"l1.perfect=true", "rt.memory.by_shader=true",
                                                            "simt.cost.node_fetch=" + std::to_string(instructions)});
    EXPECT_EQ(value(stats, "gpu.cycles"),
              kStart + 5 * shader_visit(kBox) + shader_visit(kTriangle) + finish(1, kL1Hit));
    EXPECT_EQ(value(stats, "gpu.simt.instructions.node_fetch"), 6 * instructions);
    EXPECT_EQ(value(stats, "gpu.rt.shader_fetch.batches"), 6U);
    EXPECT_EQ(value(stats, "gpu.rt.shader_fetch.sectors"), 6 * kNodeSectors);
    EXPECT_EQ(value(stats, "gpu.rt.node_sectors"), 6 * kNodeSectors);
  }
}

// 32 different leaves: one call of the shader, whose 64 sectors leave one per cycle; all lanes go on together.
TEST(DirectedAlternatives, ShaderCoresFetchAWarpsNodesTogether) {
  Directed d = directed(8, 6);
  RayGroup& group = d.groups[0];
  group.nodes.push_back(node(1, 2, 6, NodeKind::triangle));
  for (unsigned lane = 0; lane < 6; ++lane) {
    add_round(group.rays[lane], {internal_event(0, 1U << lane), leaf_event(2 + lane, LeafOutcome::miss)});
  }
  const auto shader_visit = [&](Cycle sectors, Cycle unit) {
    return 1 + kMessage + (sectors - 1) + kL1Hit + phase(24) + kMessage + 1 + unit;
  };
  const ordered_json stats = simulated(d, {"l1.perfect=true", "rt.memory.by_shader=true"});
  EXPECT_EQ(value(stats, "gpu.cycles"),
            kStart + shader_visit(kNodeSectors, kBox) + shader_visit(6 * kNodeSectors, kTriangle) + finish(3, kL1Hit));
  EXPECT_EQ(value(stats, "gpu.rt.shader_fetch.batches"), 2U);
}

// Two warps in lock step, the second launched a cycle after the first: on an RT unit each they do not meet.
TEST(DirectedAlternatives, RtUnitsOfAnSm) {
  Directed d = pointer_chase(12);
  d.groups.push_back(d.groups[0]);
  const Cycle alone = kStart + 12 * visit(kL1Hit, kBox) + visit(kL1Hit, kTriangle) + finish(1, kL1Hit);
  const std::vector<std::string> settings = {"l1.perfect=true", "gpu.resident_warps=2", "rt.box.count=1",
                                             "rt.triangle.count=1"};
  std::vector<std::string> two = settings;
  two.push_back("gpu.rt_units=2");
  const ordered_json apart = simulated(d, two);
  EXPECT_EQ(value(apart, "gpu.cycles"), alone + 1);
  EXPECT_EQ(value(apart, "gpu.sm0.rt.selections"), 13U);
  EXPECT_EQ(value(apart, "gpu.sm0.rt1.selections"), 13U);
  // On one unit they meet at its port: the second warp's sectors wait a cycle for the first's, once.
  EXPECT_EQ(value(simulated(d, settings), "gpu.cycles"), alone + 2);
}

TEST(DirectedAlternatives, SphereUnit) {
  for (const Cycle latency : {Cycle{37}, Cycle{5}}) {
    Directed d = directed(8, 1);
    d.header.accel = traces::AccelKind::ellipsoid;
    add_round(d.groups[0].rays[0], chain(d.groups[0], 5, LeafOutcome::miss));
    d.groups[0].nodes.back().child_kinds[0] = NodeKind::procedural;
    const std::vector<std::string> settings = {"l1.perfect=true", "rt.sphere.latency=" + std::to_string(latency)};
    EXPECT_EQ(value(simulated(d, settings), "gpu.cycles"),
              kStart + 5 * visit(kL1Hit, kBox) + visit(kL1Hit, kTransform + 1 + latency) + finish(1, kL1Hit));
    const ordered_json stats =
        simulated(d, {"l1.perfect=true", "rt.gaussian.enabled=true", "rt.gaussian.latency=" + std::to_string(latency)});
    EXPECT_EQ(value(stats, "gpu.cycles"),
              kStart + 5 * visit(kL1Hit, kBox) + visit(kL1Hit, kTransform + 1 + latency) + finish(1, kL1Hit));
    EXPECT_EQ(value(stats, "gpu.rt.ray_gaussian.operations"), 1U);
    EXPECT_EQ(value(stats, "gpu.rt.ray_sphere.operations"), 0U);
  }
}

TEST(DirectedAlternatives, PerfectL2) {
  EXPECT_EQ(value(simulated(pointer_chase(5), {"l2.perfect=true"}), "gpu.cycles"),
            kStart + 5 * visit(kL2Hit, kBox) + visit(kL2Hit, kTriangle) + finish(1, kL2Hit));
}

// The second sector follows by the socket's two cycles alone: a perfect DRAM has no data bus.
TEST(DirectedAlternatives, PerfectDram) {
  const auto cold_visit = [](Cycle unit) { return 1 + dram(0) + 2 + 1 + unit; };
  EXPECT_EQ(value(simulated(pointer_chase(5), {"dram.perfect=true"}), "gpu.cycles"),
            kStart + 5 * cold_visit(kBox) + cold_visit(kTriangle) + finish(1, kL2Hit));
}

// 256 B of a slice hold four nodes: nodes 1, 2, 3 lie in the first, nodes 4 to 6 in the second, each with a row to
// open.
TEST(DirectedAlternatives, Channels) {
  const ordered_json stats = simulated(pointer_chase(5), {"l2.slices=2"});
  EXPECT_EQ(value(stats, "gpu.cycles"), kStart + 2 * dram_visit(kRowMiss, kBox) + 3 * dram_visit(kRowHit, kBox) +
                                            dram_visit(kRowHit, kTriangle) + finish(1, kL2Hit));
  EXPECT_EQ(value(stats, "gpu.dram.row_misses"), 2U);
}

// A root that pushes five leaves, of which the warp buffer keeps two: two pairs leave, one per cycle, and come back
// when the lane has used up what is there.
TEST(DirectedAlternatives, ShortStack) {
  Directed d = directed(8, 1);
  RayGroup& group = d.groups[0];
  group.nodes.push_back(node(1, 2, 5, NodeKind::triangle));
  std::vector<Event> events = {internal_event(0, 0b11111)};
  for (unsigned i = 0; i < 5; ++i) events.push_back(leaf_event(2 + i, LeafOutcome::miss));
  add_round(group.rays[0], events);
  const Cycle deep = kStart + visit(kL1Hit, kBox) + 5 * visit(kL1Hit, kTriangle) + finish(1, kL1Hit);
  EXPECT_EQ(value(simulated(d, {"l1.perfect=true", "rt.warp_buffer.spill=false"}), "gpu.cycles"), deep);
  const ordered_json stats = simulated(d, {"l1.perfect=true", "rt.warp_buffer.stack_entries=2"});
  EXPECT_EQ(value(stats, "gpu.cycles"), deep + (2 - 1) + 2 * kL1Hit);
  EXPECT_EQ(value(stats, "gpu.rt.stack.spills"), 2U);
  EXPECT_EQ(value(stats, "gpu.rt.stack.fills"), 2U);
  EXPECT_EQ(value(stats, "gpu.rt.stack.max_spilled"), 4U);
  EXPECT_EQ(value(stats, "gpu.l1.stack.reads"), 2U);
  EXPECT_EQ(value(stats, "gpu.l1.stack.writes"), 2U);
}

}  // namespace
}  // namespace grtx::sim
