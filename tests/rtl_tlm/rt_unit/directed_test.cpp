// SPDX-License-Identifier: Apache-2.0
// Small hand-written traces through the whole GPU, with the total computed by hand: gpu.cycles must be exactly that.
// The pages in docs/model give each step; directed.h names them.
#include "rtl_tlm/rt_unit/directed.h"

namespace grtx::sim {
namespace {

using namespace test;

TEST(Directed, PointerChaseThroughAPerfectL1) {
  for (const unsigned length : {1U, 5U, 40U}) {
    Directed d = directed(8, 1);
    add_round(d.groups[0].rays[0], chain(d.groups[0], length, LeafOutcome::miss));
    EXPECT_EQ(value(simulated(d, kPerfectL1), "gpu.cycles"),
              kStart + length * visit(kL1Hit, kBox) + visit(kL1Hit, kTriangle) + finish(1, kL1Hit))
        << length;
  }
}

// The same warp twice, one after the other: the first finds its nodes in DRAM, the second in the L1.
TEST(Directed, PointerChaseInDramThenInTheL1) {
  for (const unsigned length : {1U, 5U, 20U}) {  // all in one DRAM row of 2 KB
    Directed d = directed(8, 1);
    add_round(d.groups[0].rays[0], chain(d.groups[0], length, LeafOutcome::miss));
    d.groups.push_back(d.groups[0]);
    const Cycle cold = kStart + dram_visit(kRowMiss, kBox) + (length - 1) * dram_visit(kRowHit, kBox) +
                       dram_visit(kRowHit, kTriangle) + finish(1, kL2Hit);
    const Cycle warm = kStart + length * visit(kL1Hit, kBox) + visit(kL1Hit, kTriangle) + finish(1, kL2Hit);
    const ordered_json stats = simulated(d);
    EXPECT_EQ(value(stats, "gpu.cycles"), cold + warm) << length;
    EXPECT_EQ(value(stats, "gpu.dram.row_misses"), 1U);
    EXPECT_EQ(value(stats, "gpu.dram.row_hits"), 2 * length + 1);
    EXPECT_EQ(value(stats, "gpu.l1.node.hits"), 2 * (length + 1));
  }
}

// With an L1 of one line the second warp finds nothing there but in the L2: by its last line, its first is gone.
TEST(Directed, PointerChaseInTheL2) {
  for (const unsigned length : {5U, 20U}) {
    Directed d = directed(8, 1);
    add_round(d.groups[0].rays[0], chain(d.groups[0], length, LeafOutcome::miss));
    d.groups.push_back(d.groups[0]);
    const Cycle cold = kStart + dram_visit(kRowMiss, kBox) + (length - 1) * dram_visit(kRowHit, kBox) +
                       dram_visit(kRowHit, kTriangle) + finish(1, kL2Hit);
    const Cycle warm = kStart + length * visit(kL2Hit, kBox) + visit(kL2Hit, kTriangle) + finish(1, kL2Hit);
    const ordered_json stats = simulated(d, {"l1.bytes=128", "l1.ways=1"});
    EXPECT_EQ(value(stats, "gpu.cycles"), cold + warm) << length;
    EXPECT_EQ(value(stats, "gpu.l1.node.hits"), 0U);
    EXPECT_EQ(value(stats, "gpu.l2.node.hits"), 2 * (length + 1));
  }
}

// 32 rays on one path cost what one costs, but for the 16 stores of their pixels.
TEST(Directed, FullyCoherentWarp) {
  constexpr unsigned kLength = 6;
  Directed d = directed(8, 32);
  const std::vector<Event> events = chain(d.groups[0], kLength, LeafOutcome::miss);
  for (traces::Ray& ray : d.groups[0].rays) add_round(ray, events);
  const Cycle path = kStart + kLength * visit(kL1Hit, kBox) + visit(kL1Hit, kTriangle);
  const ordered_json wide = simulated(d, kPerfectL1);
  EXPECT_EQ(value(wide, "gpu.cycles"), path + finish(kWarpPixels, kL1Hit));
  EXPECT_EQ(value(wide, "gpu.rt.node_fetches"), kLength + 1);
  EXPECT_EQ(wide.at("gpu.rt.simt_efficiency").at("value"), 1.0);
  // Four pipelines: the lanes come back in eight groups, one per cycle. The first group opens the next fetch, the
  // others join it while it is under way, so a path costs no more fetches and ends ceil(32 / 4) - 1 cycles later, once.
  const ordered_json narrow = simulated(d, {"l1.perfect=true", "rt.box.count=4", "rt.triangle.count=4"});
  EXPECT_EQ(value(narrow, "gpu.cycles"), path + 7 + finish(kWarpPixels, kL1Hit));
  EXPECT_EQ(value(narrow, "gpu.rt.node_fetches"), kLength + 1);
}

// 32 rays to 32 leaves, over a root of six and six nodes of six: from the second level on the port is the limit.
TEST(Directed, FullyDivergentWarp) {
  Directed d = directed(8, 32);
  RayGroup& group = d.groups[0];
  group.nodes.push_back(node(1, 2, 6, NodeKind::internal));
  for (unsigned i = 0; i < 6; ++i) group.nodes.push_back(node(2 + i, 8 + 6 * i, 6, NodeKind::triangle));
  for (unsigned lane = 0; lane < 32; ++lane) {
    const unsigned first = lane % 6, second = lane / 6;
    add_round(group.rays[lane], {internal_event(0, 1U << first), internal_event(1 + first, 1U << second),
                                 leaf_event(8 + 6 * first + second, LeafOutcome::miss)});
  }
  // The six nodes are issued one after the other: the first lanes are back after one visit, from then on leaf sectors
  // keep the port busy until all 32 leaves are issued; then the last response and its test.
  const Cycle first_back = kStart + visit(kL1Hit, kBox) + visit(kL1Hit, kBox);
  const Cycle last_leaf = first_back + 32 * kNodeSectors + kL1Hit + 1 + kTriangle;
  const ordered_json stats = simulated(d, kPerfectL1);
  EXPECT_EQ(value(stats, "gpu.cycles"), last_leaf + finish(kWarpPixels, kL1Hit));
  EXPECT_EQ(value(stats, "gpu.rt.node_fetches"), 1U + 6 + 32);
  EXPECT_EQ(value(stats, "gpu.rt.node_visits"), 3U * 32);
}

// The last any-hit shader of 32 lanes stores an entry, 8 sectors, from the cycle in which it is done. TraceDone is
// there two cycles later: the loads of the blending phase wait for the other six.
constexpr Cycle kStoresFirst = 8 - 2 * kMessage;

// Every ray of the warp hits each of four leaves: one batch per leaf, the warp stands still while its shader runs.
TEST(Directed, AnyHitStorm) {
  constexpr unsigned kLeaves = 4;
  Directed d = directed(8, 32);
  RayGroup& group = d.groups[0];
  group.nodes.push_back(node(1, 2, kLeaves, NodeKind::triangle));
  std::vector<Event> events = {internal_event(0, 0b1111)};
  for (unsigned i = 0; i < kLeaves; ++i) events.push_back(leaf_event(2 + i, LeafOutcome::inserted));
  for (traces::Ray& ray : group.rays) {
    add_round(ray, events);
    end_round(ray, kLeaves, {0, 1, 2, 3}, false);
  }
  // A batch: link, the shader, link. Hits come near first, so none shifts: a shader that finds entries reads the last
  // one, t and id, 32 lanes x 4 B = 4 sectors each, one per cycle; the first finds none.
  const Cycle loads = 2 * 4;
  const Cycle empty_batch = kMessage + phase(kAnyHit) + kMessage;
  const Cycle batch = empty_batch + (loads - 1) + kL1Hit;
  const Cycle traced = kStart + visit(kL1Hit, kBox) + kLeaves * visit(kL1Hit, kTriangle) + empty_batch + 3 * batch;
  // Blending: four entries of 8 sectors; records of 48 B at 0, 48, 96, 144: 2 sectors each; colours of 12 B at 0, 12,
  // 24, 36: 1, 1, 2, 1 sectors.
  const Cycle sectors = kLeaves * loads + 4 * 2 + 5;
  const Cycle blend =
      kStoresFirst + (sectors - 1) + kL1Hit + phase(kBlendFixed + kLeaves * (kBlendEntry + kShCoefficient));
  const Cycle end = phase(kEpilogue) + (kWarpPixels - 1) + kL1Hit + kMessage;
  const ordered_json stats = simulated(d, kPerfectL1);
  EXPECT_EQ(value(stats, "gpu.cycles"), traced + kMessage + blend + end);
  EXPECT_EQ(value(stats, "gpu.rt.any_hit.batches"), kLeaves);
  EXPECT_EQ(value(stats, "gpu.rt.any_hit.timeouts"), 0U);
  EXPECT_EQ(value(stats, "gpu.simt.blended"), 32U * kLeaves);
}

// The same without a shader: the heaps of all lanes work at once, and blending takes the hits out of them while it
// loads records and colours.
TEST(Directed, AnyHitStormInHeaps) {
  constexpr unsigned kLeaves = 4;
  Directed d = directed(8, 32);
  RayGroup& group = d.groups[0];
  group.nodes.push_back(node(1, 2, kLeaves, NodeKind::triangle));
  std::vector<Event> events = {internal_event(0, 0b1111)};
  for (unsigned i = 0; i < kLeaves; ++i) events.push_back(leaf_event(2 + i, LeafOutcome::inserted));
  for (traces::Ray& ray : group.rays) {
    add_round(ray, events);
    end_round(ray, kLeaves, {0, 1, 2, 3}, false);
  }
  for (const Cycle level : {Cycle{2}, Cycle{20}}) {
    // Heaps of 1, 2, 3 and 4 entries have 0, 1, 1 and 2 levels below the root; emptying them, one more each.
    const Cycle entering = kLeaves * 2 + level * (0 + 1 + 1 + 2), emptying = kLeaves * 2 + level * (1 + 2 + 2 + 3);
    const Cycle traced = kStart + visit(kL1Hit, kBox) + kLeaves * visit(kL1Hit, kTriangle) + entering;
    const Cycle sectors = 4 * 2 + 5;
    const Cycle blend =
        std::max(emptying, (sectors - 1) + kL1Hit) + phase(kBlendFixed + kLeaves * (kBlendEntry + kShCoefficient));
    const Cycle end = phase(kEpilogue) + (kWarpPixels - 1) + kL1Hit + kMessage;
    const ordered_json stats = simulated(d, {"l1.perfect=true", "rt.any_hit_unit.enabled=true",
                                             "rt.any_hit_unit.level_latency=" + std::to_string(level)});
    EXPECT_EQ(value(stats, "gpu.cycles"), traced + kMessage + blend + end) << level;
    EXPECT_EQ(value(stats, "gpu.rt.any_hit.batches"), 0U);
    EXPECT_EQ(value(stats, "gpu.rt.any_hit.unit.hits"), 32U * kLeaves);
    EXPECT_EQ(value(stats, "gpu.simt.blended"), 32U * kLeaves);
  }
}

// Two entries fill the buffer, the third is lost: the next round starts at the root, and reads no entry.
TEST(Directed, CheckpointOverflow) {
  Directed d = directed(1, 1, 2);
  RayGroup& group = d.groups[0];
  traces::Ray& ray = group.rays[0];
  group.nodes.push_back(node_definition(1, 2, {NodeKind::triangle, NodeKind::internal}));
  group.nodes.push_back(node(3, 4, 3, NodeKind::triangle));
  // The first hit fills the k-buffer of one entry; the three leaves of node 3 lie behind it.
  add_round(ray, {internal_event(0, 0b11), leaf_event(2, LeafOutcome::inserted), internal_event(1, 0, 0b011)});
  ray.rounds.back().overflow = true;
  end_round(ray, 1, {0}, false);
  add_round(ray, {internal_event(0, 0b10), internal_event(1, 0b001), leaf_event(4, LeafOutcome::inserted)});
  end_round(ray, 1, {1}, true);
  const Cycle any_hit = kMessage + phase(kAnyHit) + kMessage;
  const Cycle call = phase(kEvictMove) + phase(kTraceCall) + kMessage + 1;
  // Both rounds make the same visits in another order. The two entries (sector 0, and 0 to 1) are two items of the four
  // a cycle, handed over in the cycle of the result: they delay nothing.
  const Cycle trace = 2 * visit(kL1Hit, kBox) + visit(kL1Hit, kTriangle) + any_hit;
  // One entry: t, id, 48 B of record 0 or 1 (2 sectors), one of the colour.
  const Cycle blend = kMessage + (5 - 1) + kL1Hit + phase(kBlendFixed + kBlendEntry + kShCoefficient);
  const ordered_json stats = simulated(d, {"l1.perfect=true", "l1.banks=64"});
  EXPECT_EQ(value(stats, "gpu.cycles"),
            kMessage + phase(kPrologue) + 2 * (call + trace + blend) + phase(kEpilogue) + kL1Hit + kMessage);
  EXPECT_EQ(value(stats, "gpu.rt.checkpoint.entries_written"), 2U);
  EXPECT_EQ(value(stats, "gpu.rt.checkpoint.entries_read"), 0U);
  EXPECT_EQ(value(stats, "gpu.rt.checkpoint.sectors_written"), 3U);
}

// 31 rays hit the leaf under the root; the last ray follows a chain first.
Directed straggler(unsigned chain_length) {
  Directed d = directed(8, 32);
  RayGroup& group = d.groups[0];
  std::vector<Event> long_way = chain(group, chain_length + 1, LeafOutcome::inserted);
  // The root gets a second child, which must follow the first: the leaf of the others.
  group.nodes[0] = node(1, 2, 2, NodeKind::internal);
  group.nodes[0].child_kinds[1] = NodeKind::triangle;
  group.nodes[0].child_base = 100;  // the chain continues at unit 100, the leaf is unit 101
  for (unsigned i = 1; i < group.nodes.size(); ++i) {
    group.nodes[i].address = i == 1 ? 100 : 200 + i;
    group.nodes[i].child_base = 200 + i + 1;
  }
  long_way.back().node = static_cast<std::uint32_t>(200 + group.nodes.size());
  for (unsigned lane = 0; lane < 32; ++lane) {
    traces::Ray& ray = group.rays[lane];
    if (lane == 31) {
      add_round(ray, long_way);
    } else {
      add_round(ray, {internal_event(0, 0b10), leaf_event(101, LeafOutcome::inserted)});
    }
    end_round(ray, 1, {0}, false);
  }
  return d;
}

// One entry of 32 lanes: t and id 4 sectors each, record 0 two, colour 0 one.
constexpr Cycle kBlendOne = kMessage + (11 - 1) + kL1Hit + phase(kBlendFixed + kBlendEntry + kShCoefficient);
constexpr Cycle kPixelsOut = phase(kEpilogue) + (kWarpPixels - 1) + kL1Hit + kMessage;

// A straggler that takes longer than the timeout: the others go to the shader without it, and the warp lasts as long as
// the straggler does.
TEST(Directed, OneStraggler) {
  constexpr unsigned kChain = 5;
  const Directed d = straggler(kChain);
  const Cycle alone = visit(kL1Hit, kBox) + kChain * visit(kL1Hit, kBox) + visit(kL1Hit, kTriangle);
  const Cycle any_hit = kMessage + phase(kAnyHit) + kMessage;
  const ordered_json stats = simulated(d, kPerfectL1);
  // Both second nodes are fetched in one cycle, the others' leaf first (lane order): two sectors' delay.
  EXPECT_EQ(value(stats, "gpu.cycles"), kStart + alone + kNodeSectors + any_hit + kBlendOne + kPixelsOut);
  EXPECT_EQ(value(stats, "gpu.rt.any_hit.batches"), 2U);
  EXPECT_EQ(value(stats, "gpu.rt.any_hit.timeouts"), 1U);
}

// With a timeout longer than its way the other 31 wait for it: one batch, at the same time.
TEST(Directed, OneStragglerIsWaitedFor) {
  constexpr unsigned kChain = 5;
  const Directed d = straggler(kChain);
  const Cycle alone = visit(kL1Hit, kBox) + kChain * visit(kL1Hit, kBox) + visit(kL1Hit, kTriangle);
  const Cycle any_hit = kMessage + phase(kAnyHit) + kMessage;
  const ordered_json stats = simulated(d, {"l1.perfect=true", "rt.any_hit.timeout=100000"});
  EXPECT_EQ(value(stats, "gpu.cycles"),
            kStart + alone + kNodeSectors + any_hit + kStoresFirst + kBlendOne + kPixelsOut);
  EXPECT_EQ(value(stats, "gpu.rt.any_hit.batches"), 1U);
  EXPECT_EQ(value(stats, "gpu.rt.any_hit.timeouts"), 0U);
  // From the 31 hits to the straggler's: its chain and leaf, but for the leaf that the others visited.
  EXPECT_EQ(value(stats, "gpu.rt.any_hit.wait_cycles"),
            kChain * visit(kL1Hit, kBox) + visit(kL1Hit, kTriangle) + kNodeSectors - visit(kL1Hit, kTriangle));
}

}  // namespace
}  // namespace grtx::sim
