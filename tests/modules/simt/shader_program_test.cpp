// SPDX-License-Identifier: Apache-2.0
// What shader phases cost: instructions of the longest lane, sectors after coalescing, buffers of each lane kept in
// step.
#include "grtx/modules/simt/decide/shader_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "grtx/base/error.h"
#include "grtx/modules/messages/lane_loop.h"
#include "modules/simt/simt_bench.h"

namespace grtx::modules {
namespace {

using traces::LeafOutcome;

constexpr unsigned kResident = 4;
constexpr unsigned kSlot = 2;

struct Program {
  explicit Program(const traces::Header& header, const ShaderCosts& costs = {}, const HitHeap& heap = {})
      : map(header, {1, kResident, 0}), program(header, map, costs, 0, kResident, heap) {}
  MemoryMap map;
  ShaderProgram program;
  ShaderPhase phase;

  void any_hit(LaneMask lanes, LeafOutcome outcome, unsigned shifts) {
    AnyHitBatch batch;
    batch.slot = kSlot;
    batch.lanes = lanes;
    for_each_bit(lanes, [&](unsigned lane) {
      batch.outcome[lane] = outcome;
      batch.shifts[lane] = static_cast<std::uint16_t>(shifts);
    });
    program.any_hit(batch, phase);
  }
};

std::size_t count(const std::vector<SectorAccess>& accesses, Region region) {
  return static_cast<std::size_t>(
      std::count_if(accesses.begin(), accesses.end(), [&](const SectorAccess& a) { return a.region == region; }));
}

constexpr LaneMask kAllLanes = 0xFFFF'FFFFU;

TEST(ShaderAnyHit, OneEntryOf32LanesIsFourSectorsAField) {
  Program p(simt_header());
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
  p.program.begin(kSlot, group);
  p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  EXPECT_TRUE(p.phase.loads.empty());
  ASSERT_EQ(p.phase.stores.size(), 8u);
  for (unsigned i = 0; i < 8; ++i) {  // t of all lanes, then id of all lanes, contiguous
    EXPECT_EQ(p.phase.stores[i].address, p.map.k_buffer(kSlot, 0, 0, 0) + i * kSectorBytes);
  }
  EXPECT_EQ(p.phase.instructions, 12u);
}

TEST(ShaderAnyHit, EightNeighbouringLanesShareASector) {
  struct Case {
    LaneMask lanes;
    std::size_t sectors;  // of one field
  };
  for (const Case& c : {Case{0x1, 1}, Case{0xFF, 1}, Case{0x180, 2}, Case{0x8080'8080, 4}, Case{0xFF00'0000, 1}}) {
    Program p(simt_header());
    const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
    p.program.begin(kSlot, group);
    p.any_hit(c.lanes, LeafOutcome::inserted, 0);
    EXPECT_EQ(p.phase.stores.size(), 2 * c.sectors) << std::hex << c.lanes;
  }
}

TEST(ShaderAnyHit, LanesAtDifferentFillDoNotCoalesce) {
  Program p(simt_header());
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
  p.program.begin(kSlot, group);
  p.any_hit(0xF, LeafOutcome::inserted, 0);   // lanes 0-3 hold one entry
  p.any_hit(0xFF, LeafOutcome::inserted, 0);  // entry 1 of lanes 0-3, entry 0 of lanes 4-7
  EXPECT_EQ(p.phase.loads.size(), 2u);        // lanes 0-3 compare with entry 0: one sector per field
  EXPECT_EQ(p.phase.stores.size(), 4u);       // two entries, two fields
}

// A warp that walks together may meet the hit that displaces before those that fill the buffer. It was counted as an
// entry of its own, so the buffer seemed full too early.
TEST(ShaderAnyHit, ADisplacingHitThatComesFirstIsNoFurtherEntry) {
  Program p(simt_header());
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
  p.program.begin(kSlot, group);
  p.any_hit(kAllLanes, LeafOutcome::displaced, 0);
  p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  EXPECT_EQ(p.phase.stores[0].address, p.map.k_buffer(kSlot, 0, 0, 0));
  p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  EXPECT_EQ(p.phase.stores[0].address, p.map.k_buffer(kSlot, 1, 0, 0));
}

TEST(ShaderAnyHit, CostsTheShiftsOfTheLongestLane) {
  Program p(simt_header());
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
  p.program.begin(kSlot, group);
  for (int i = 0; i < 3; ++i) p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  AnyHitBatch batch;
  batch.slot = kSlot;
  batch.lanes = 0x7;
  for (unsigned lane = 0; lane < 3; ++lane) {
    batch.outcome[lane] = LeafOutcome::inserted;
    batch.shifts[lane] = static_cast<std::uint16_t>(lane);  // 0, 1, 2
  }
  p.program.any_hit(batch, p.phase);
  EXPECT_EQ(p.phase.instructions, 12u + 3 * 2);
  // Iterations 1, 2, 3 run 3, 2 and 1 of the lanes; all at the same entry, in one sector per field.
  EXPECT_EQ(p.phase.loads.size(), 3u * 2);
  EXPECT_EQ(p.phase.stores.size(), 3u * 2);
  EXPECT_EQ(p.phase.stores[0].address, p.map.k_buffer(kSlot, 3, 0, 0));
  EXPECT_EQ(p.phase.stores[4].address, p.map.k_buffer(kSlot, 1, 0, 0));
}

TEST(ShaderAnyHit, OnlyCheckpointingWritesEvictions) {
  for (const bool checkpoint : {false, true}) {
    for (const LeafOutcome outcome : {LeafOutcome::displaced, LeafOutcome::rejected, LeafOutcome::ignored}) {
      Program p(checkpoint ? checkpointing(simt_header()) : simt_header());
      const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
      p.program.begin(kSlot, group);
      for (unsigned i = 0; i < 4; ++i) p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
      const bool evicts = checkpoint && outcome != LeafOutcome::ignored;
      for (unsigned i = 0; i < 5; ++i) {
        p.any_hit(kAllLanes, outcome, 0);
        // Eviction buffers are arrays per ray: no two lanes share a sector; four entries of a ray do.
        ASSERT_EQ(count(p.phase.stores, Region::eviction), evicts ? 32u : 0u);
        EXPECT_EQ(count(p.phase.stores, Region::k_buffer), outcome == LeafOutcome::displaced ? 8u : 0u);
        if (!evicts) continue;
        const std::uint64_t expected = p.map.eviction_entry(p.map.ray_slot(0, kSlot, 0), i) / kSectorBytes;
        const auto first = std::find_if(p.phase.stores.begin(), p.phase.stores.end(),
                                        [](const SectorAccess& a) { return a.region == Region::eviction; });
        EXPECT_EQ(first->address / kSectorBytes, expected);
        EXPECT_EQ(expected, p.map.eviction_entry(p.map.ray_slot(0, kSlot, 0), 0) / kSectorBytes + i / 4);
      }
      EXPECT_EQ(p.program.counters().evictions, evicts ? 5u * 32 : 0u);
    }
  }
}

TEST(ShaderBlend, TrafficAndInstructionsGrowWithTheShDegree) {
  struct Case {
    unsigned degree;
    std::size_t sh_sectors;  // of record 0, which begins at a sector
    traces::NodeLayout layout = traces::NodeLayout::vulkan_sim;
  };
  for (const Case& c : {Case{0, 1}, Case{1, 2}, Case{2, 4}, Case{3, 6}, Case{0, 1, traces::NodeLayout::quantised},
                        Case{2, 2, traces::NodeLayout::quantised}, Case{3, 3, traces::NodeLayout::quantised}}) {
    traces::Header header = simt_header();
    header.layout = c.layout;
    header.sh_degree = c.degree;
    header.sh_record_bytes = traces::sh_record_bytes(c.layout, c.degree);
    const unsigned a_coefficient = c.layout == traces::NodeLayout::quantised ? 4 + 3 : 4;  // three are converted
    Program p(header);
    const traces::RayGroup group = uniform_group(
        32, {{{{LeafOutcome::inserted}, {LeafOutcome::inserted}}, {seen(0, true), seen(0, false)}, 0, 0}});
    p.program.begin(kSlot, group);
    p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
    p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
    p.program.blend(kSlot, p.phase);
    EXPECT_EQ(count(p.phase.loads, Region::sh), c.sh_sectors);
    EXPECT_EQ(count(p.phase.loads, Region::gaussian), 2u * 2);  // 48 B, all lanes the same, two entries
    EXPECT_EQ(count(p.phase.loads, Region::k_buffer), 2u * 8);
    EXPECT_EQ(p.phase.instructions, 10u + 2 * 24 + a_coefficient * (c.degree + 1) * (c.degree + 1));
    EXPECT_EQ(p.program.counters().k_buffer_mismatches, 0u);
  }
}

TEST(ShaderBlend, AColourIsMadeOnceOnAnSmAndThenTakenFromItsTable) {
  traces::Header header = simt_header();
  header.colour = traces::ColourPer::frame;
  header.gaussians = 1000;
  header.sh_degree = 3;
  header.sh_record_bytes = traces::sh_record_bytes(header.layout, header.sh_degree);
  Program p(header);
  // Two lanes, whose first entry is the same Gaussian; the second lane meets the first one's other Gaussian again.
  traces::RayGroup group;
  group.rays.push_back(make_ray(0, {{{}, {seen(8, true), seen(100, true)}, 2, 0}}));
  group.rays.push_back(make_ray(1, {{{}, {seen(8, true), seen(500, false), seen(100, true)}, 3, 0}}));
  const auto blend = [&](unsigned slot) {
    p.program.begin(slot, group);
    p.program.blend(slot, p.phase);
  };
  constexpr unsigned kTaken = 4, kMade = 13 + 4 * 16;
  blend(kSlot);  // makes 8 and 100, and sees at once what it has made
  EXPECT_EQ(p.phase.instructions, 10u + 3 * 24 + 3 * kTaken + 2 * kMade);
  EXPECT_EQ(count(p.phase.loads, Region::sh), 3u + 2 * 6);
  ASSERT_EQ(p.phase.stores.size(), 2u);
  EXPECT_EQ(p.phase.stores[0], (SectorAccess{p.map.colour(0, 8), Region::sh}));
  EXPECT_EQ(p.program.counters().colours_made, 2u);
  blend(kSlot + 1);  // the other warp's stores are not on their way yet
  EXPECT_EQ(p.phase.stores.size(), 2u);
  p.program.publish_colours(kSlot);
  blend(0);
  EXPECT_EQ(p.phase.instructions, 10u + 3 * 24 + 3 * kTaken);
  EXPECT_EQ(count(p.phase.loads, Region::sh), 3u);
  EXPECT_TRUE(p.phase.stores.empty());
  group.frame = 1;  // the camera has moved
  blend(0);
  EXPECT_EQ(p.phase.stores.size(), 2u);
}

TEST(ShaderBlend, AColourThatIsMadeReadsTheGaussiansPlaceIfAHitBringsItsAlpha) {
  traces::Header header = simt_header();
  header.colour = traces::ColourPer::frame;
  header.gaussians = 1000;
  HitHeap heap;
  heap.enabled = heap.alpha = true;
  Program p(header, {}, heap);
  traces::RayGroup group;
  group.rays.push_back(make_ray(0, {{{}, {seen(8, true)}, 1, 0}}));
  p.program.begin(kSlot, group);
  p.program.blend(kSlot, p.phase);
  EXPECT_EQ(count(p.phase.loads, Region::gaussian), 1u);
  EXPECT_EQ(count(p.phase.loads, Region::sh), 2u);
}

TEST(ShaderBlend, DistinctGaussiansShareOnlyTheSectorsTheyOverlapIn) {
  traces::Header header = simt_header();
  header.sh_record_bytes = 192;
  Program p(header);
  traces::RayGroup group;
  for (unsigned lane = 0; lane < 32; ++lane) group.rays.push_back(make_ray(lane, {{{}, {seen(lane, true)}, 1, 0}}));
  p.program.begin(kSlot, group);
  p.program.blend(kSlot, p.phase);
  // 32 records of 48 B in a row fill 48 sectors; 32 of 192 B fill 192.
  EXPECT_EQ(count(p.phase.loads, Region::gaussian), 48u);
  EXPECT_EQ(count(p.phase.loads, Region::sh), 192u);
}

TEST(ShaderBlend, RunsUntilTheLongestLaneIsDoneAndSkipsTheColourWhenNoLaneBlends) {
  Program p(simt_header());
  traces::RayGroup group;
  group.rays.push_back(make_ray(0, {{{}, {seen(1, false)}, 1, 0}}));
  group.rays.push_back(make_ray(1, {{{}, {seen(1, true), seen(2, false), seen(500, true)}, 3, 0}}));
  group.rays.push_back(make_ray(2, {}));
  p.program.begin(kSlot, group);
  EXPECT_EQ(p.program.active_lanes(kSlot), 0b011u);
  p.program.blend(kSlot, p.phase);
  EXPECT_EQ(p.phase.instructions, 10u + 3 * 24 + 2 * 4);  // iterations 0 and 2 blend
  EXPECT_EQ(count(p.phase.loads, Region::sh), 2u);
  EXPECT_EQ(p.program.counters().entries_processed, 4u);
  EXPECT_EQ(p.program.counters().entries_blended, 2u);
  EXPECT_EQ(p.program.active_lanes(kSlot), 0u);
}

traces::Header single_round(unsigned k) {
  traces::Header header = simt_header();
  header.tracing = traces::Tracing::single;
  header.k = k;
  return header;
}

TEST(ShaderSingleRound, AppendsWithoutReading) {
  Program p(single_round(64));
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
  p.program.begin(kSlot, group);
  for (unsigned i = 0; i < 5; ++i) {
    p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
    EXPECT_TRUE(p.phase.loads.empty());
    ASSERT_EQ(p.phase.stores.size(), 8u);
    EXPECT_EQ(p.phase.stores[0].address, p.map.k_buffer(kSlot, i, 0, 0));
    EXPECT_EQ(p.phase.instructions, 12u);
  }
}

TEST(ShaderSingleRound, AFullBufferIsAHeap) {
  Program p(single_round(8));
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
  p.program.begin(kSlot, group);
  for (unsigned i = 0; i < 7; ++i) p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  p.any_hit(kAllLanes, LeafOutcome::inserted, 5);  // fills: reads the other seven, writes itself and the five moved
  EXPECT_EQ(p.phase.loads.size(), 7u * 8);
  EXPECT_EQ(p.phase.stores.size(), 6u * 8);
  EXPECT_EQ(p.phase.instructions, 12u + 3 * 5);
  p.any_hit(kAllLanes, LeafOutcome::displaced, 2);  // root, two children on each of three levels; three written
  EXPECT_EQ(p.phase.loads.size(), 7u * 8);
  EXPECT_EQ(p.phase.stores.size(), 3u * 8);
  EXPECT_EQ(p.phase.stores[16].address, p.map.k_buffer(kSlot, 3, 0, 0));  // of the path 0, 1, 3
  EXPECT_EQ(p.phase.instructions, 12u + 3 * 2);
  p.any_hit(kAllLanes, LeafOutcome::rejected, 0);  // only the root is compared with
  EXPECT_EQ(p.phase.loads.size(), 8u);
  EXPECT_TRUE(p.phase.stores.empty());
}

TEST(ShaderSingleRound, ReadsTheHeapFromTheRootToItsLeaves) {
  Program p(single_round(8));
  const traces::RayGroup group = uniform_group(32, std::vector<RoundScript>(1));
  p.program.begin(kSlot, group);
  const auto read = [&] {
    std::vector<std::uint64_t> entries;
    for (std::size_t i = 0; i < p.phase.loads.size(); i += 8) {
      for (unsigned e = 0; e < 8; ++e) {
        if (p.phase.loads[i].address == p.map.k_buffer(kSlot, e, 0, 0)) entries.push_back(e);
      }
    }
    return entries;
  };
  using Entries = std::vector<std::uint64_t>;
  for (unsigned i = 0; i < 7; ++i) p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  p.any_hit(kAllLanes, LeafOutcome::inserted, 1);
  EXPECT_EQ(read(), (Entries{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(p.phase.instructions, 12u + 3 * 4) << "four inner entries are compared, whatever moves";
  EXPECT_TRUE(p.phase.steps.empty()) << "all entries are known beforehand";
  p.any_hit(kAllLanes, LeafOutcome::displaced, 2);
  EXPECT_EQ(read(), (Entries{0, 1, 2, 3, 4, 7, 7}));  // the eighth entry is the only one of the last level
  ASSERT_EQ(p.phase.steps.size(), 4u) << "each level waits for the one above";
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(p.phase.steps[i], 8u * (1 + 2 * i)) << i;
}

TEST(ShaderSingleRound, SortsInPassesBetweenTheHalvesOfTheBuffer) {
  Program p(single_round(8));
  RoundScript script{{}, {seen(1, true), seen(2, true), seen(3, true)}, 0, 0};
  script.any_hits.assign(3, {LeafOutcome::inserted});
  const traces::RayGroup group = uniform_group(32, {script});
  p.program.begin(kSlot, group);
  EXPECT_FALSE(p.program.sorts(kSlot));
  for (unsigned i = 0; i < 3; ++i) p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  p.any_hit(0x1, LeafOutcome::ignored, 0);
  unsigned passes = 0;
  for (; p.program.sorts(kSlot); ++passes) {
    p.program.sort(kSlot, p.phase);
    EXPECT_EQ(p.phase.kind, PhaseKind::sort);
    EXPECT_EQ(p.phase.instructions, 6u * 3);
    ASSERT_EQ(p.phase.loads.size(), 3u * 8);
    ASSERT_EQ(p.phase.stores.size(), 3u * 8);
    EXPECT_EQ(p.phase.loads[0].address, p.map.k_buffer(kSlot, passes % 2 == 0 ? 0 : 8, 0, 0));
    EXPECT_EQ(p.phase.stores[0].address, p.map.k_buffer(kSlot, passes % 2 == 0 ? 8 : 0, 0, 0));
  }
  EXPECT_EQ(passes, 2u);  // three entries: runs of two, then all
  p.program.blend(kSlot, p.phase);
  EXPECT_EQ(p.phase.loads[0].address, p.map.k_buffer(kSlot, 0, 0, 0));
  EXPECT_EQ(p.program.counters().k_buffer_mismatches, 0u);
}

// Two lanes of 5 and 3 hits, the second of which ends after 2; batches of 2.
TEST(ShaderList, ScansTheWholeListForEachBatchAndBlendsItFromRegisters) {
  traces::Header header = single_round(8);
  header.tracing = traces::Tracing::list;
  ShaderCosts costs{.list_batch = 2};
  Program p(header, costs);
  traces::RayGroup group;
  for (const unsigned hits : {5u, 3u}) {
    RoundScript script;
    script.any_hits.assign(hits, {LeafOutcome::inserted});
    for (unsigned i = 0; i < (hits == 5 ? 5u : 2u); ++i) script.processed.push_back(seen(8 * hits + i, i != 4));
    group.rays.push_back(uniform_group(1, {script}).rays[0]);
  }
  p.program.begin(kSlot, group);
  for (unsigned i = 0; i < 5; ++i) {
    p.any_hit(i < 3 ? 0b11 : 0b01, LeafOutcome::inserted, 0);
    EXPECT_TRUE(p.phase.loads.empty());
    EXPECT_EQ(p.phase.stores[0].address, p.map.k_buffer(kSlot, i, 0, 0));
  }
  EXPECT_FALSE(p.program.blends_on(kSlot));
  for (unsigned batch = 0; batch < 3; ++batch) {
    SCOPED_TRACE(batch);
    ASSERT_TRUE(p.program.sorts(kSlot));
    p.program.sort(kSlot, p.phase);
    EXPECT_EQ(p.phase.kind, PhaseKind::sort);
    EXPECT_EQ(p.phase.instructions, 5u * (8 + 5 * 1)) << "five entries pass one place of a batch of two";
    EXPECT_EQ(p.phase.loads.size(), 5u * 2) << "both lanes' entries lie in a sector";
    EXPECT_TRUE(p.phase.stores.empty());
    EXPECT_FALSE(p.program.sorts(kSlot)) << "not before the batch is blended";
    p.program.blend(kSlot, p.phase);
    EXPECT_EQ(count(p.phase.loads, Region::k_buffer), 0u);
    const unsigned hits = batch == 2 ? 1 : 2;  // of the longer lane
    EXPECT_EQ(p.phase.instructions, 10u + hits * 24 + (batch == 2 ? 0 : hits * 4));
    EXPECT_EQ(p.program.blends_on(kSlot), batch < 2);
  }
  EXPECT_FALSE(p.program.sorts(kSlot));
  EXPECT_EQ(p.program.active_lanes(kSlot), 0u);
  EXPECT_EQ(p.program.counters().entries_processed, 7u);
  EXPECT_EQ(p.program.counters().entries_blended, 6u);
  EXPECT_EQ(p.program.counters().k_buffer_mismatches, 0u);
}

// Instructions and counters stay: only the memory requests go.
TEST(ShaderEvictMove, UnchargedEvictionsAreNoTrafficCharging) {
  ShaderCosts costs{.eviction_traffic = TrafficCharging::uncharged};
  Program p(checkpointing(simt_header()), costs);
  RoundScript second;
  second.preloaded = 4;
  const traces::RayGroup group = uniform_group(32, {RoundScript{}, second});
  p.program.begin(kSlot, group);
  p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  for (unsigned i = 0; i < 6; ++i) p.any_hit(kAllLanes, LeafOutcome::rejected, 0);
  EXPECT_EQ(count(p.phase.stores, Region::eviction), 0u);
  p.program.blend(kSlot, p.phase);
  p.program.evict_move(kSlot, p.phase);  // six entries, of which four move
  EXPECT_TRUE(p.phase.loads.empty());
  EXPECT_EQ(count(p.phase.stores, Region::k_buffer), 4u * 8);
  EXPECT_EQ(count(p.phase.stores, Region::eviction), 0u);
  EXPECT_EQ(p.phase.instructions, 8u + 4 * 6);
  EXPECT_EQ(p.program.counters().evictions, 6u * 32);
}

TEST(ShaderEvictMove, ReadsAllMovesPreloadedAndCompactsTheRest) {
  Program p(checkpointing(simt_header()));
  RoundScript second;
  second.preloaded = 4;
  RoundScript third;
  third.preloaded = 2;
  const traces::RayGroup group = uniform_group(32, {RoundScript{}, second, third});
  p.program.begin(kSlot, group);
  p.program.evict_move(kSlot, p.phase);
  EXPECT_EQ(p.phase.instructions, 8u);
  EXPECT_TRUE(p.phase.loads.empty() && p.phase.stores.empty());
  for (unsigned i = 0; i < 4; ++i) p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  for (unsigned i = 0; i < 6; ++i) p.any_hit(kAllLanes, LeafOutcome::rejected, 0);
  p.program.blend(kSlot, p.phase);

  p.program.evict_move(kSlot, p.phase);  // six entries: four to the k-buffer, two stay
  EXPECT_EQ(p.phase.instructions, 8u + 4 * 6);
  EXPECT_EQ(p.phase.loads.size(), 6u * 32);
  EXPECT_EQ(count(p.phase.stores, Region::k_buffer), 4u * 8);
  EXPECT_EQ(count(p.phase.stores, Region::eviction), 2u * 32);
  EXPECT_EQ(p.phase.stores[32].address, p.map.eviction_entry(p.map.ray_slot(0, kSlot, 0), 0));
  p.any_hit(kAllLanes, LeafOutcome::rejected, 0);  // goes behind the two that stayed
  EXPECT_EQ(p.phase.stores[0].address / kSectorBytes,
            p.map.eviction_entry(p.map.ray_slot(0, kSlot, 0), 2) / kSectorBytes);
  p.program.blend(kSlot, p.phase);

  p.program.evict_move(kSlot, p.phase);  // three entries: two move, one stays
  EXPECT_EQ(p.phase.loads.size(), 3u * 32);
  EXPECT_EQ(count(p.phase.stores, Region::k_buffer), 2u * 8);
  EXPECT_EQ(count(p.phase.stores, Region::eviction), 32u);
  EXPECT_EQ(p.program.counters().eviction_moves, (4u + 2) * 32);
}

TEST(ShaderEvictMove, WhatNobodyMovesIsNotWrittenAgain) {
  Program p(checkpointing(simt_header()));
  const traces::RayGroup group = uniform_group(32, {RoundScript{}, RoundScript{}});
  p.program.begin(kSlot, group);
  for (unsigned i = 0; i < 4; ++i) p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  for (unsigned i = 0; i < 3; ++i) p.any_hit(kAllLanes, LeafOutcome::rejected, 0);
  p.program.blend(kSlot, p.phase);
  p.program.evict_move(kSlot, p.phase);
  EXPECT_EQ(p.phase.loads.size(), 3u * 32);
  EXPECT_TRUE(p.phase.stores.empty());
}

TEST(ShaderEvictMove, AnOverflowedRoundLosesItsEvictions) {
  Program p(checkpointing(simt_header()));
  RoundScript first;
  first.eviction_dropped = 3;
  const traces::RayGroup group = uniform_group(32, {first, RoundScript{}});
  p.program.begin(kSlot, group);
  for (unsigned i = 0; i < 4; ++i) p.any_hit(kAllLanes, LeafOutcome::inserted, 0);
  for (unsigned i = 0; i < 3; ++i) p.any_hit(kAllLanes, LeafOutcome::rejected, 0);
  p.program.blend(kSlot, p.phase);
  p.program.evict_move(kSlot, p.phase);
  EXPECT_TRUE(p.phase.loads.empty());
  EXPECT_EQ(p.phase.instructions, 8u);
}

TEST(ShaderEpilogue, PixelsOfATileCoalesce) {
  const traces::Header header = simt_header();  // 64 x 64
  Program p(header);
  traces::RayGroup tile;
  for (unsigned lane = 0; lane < 32; ++lane) tile.rays.push_back(make_ray((lane / 8) * 64 + lane % 8, {}));
  p.program.begin(kSlot, tile);
  p.program.epilogue(kSlot, p.phase);
  EXPECT_EQ(p.phase.stores.size(), 16u);  // two pixels per sector
  traces::RayGroup scattered;
  for (unsigned lane = 0; lane < 32; ++lane) scattered.rays.push_back(make_ray(lane * 100, {}));
  p.program.begin(kSlot, scattered);
  p.program.epilogue(kSlot, p.phase);
  EXPECT_EQ(p.phase.stores.size(), 32u);
  EXPECT_EQ(p.phase.stores[3], (SectorAccess{p.map.pixel(300), Region::ray}));
}

TEST(ShaderProgramConservation, AMissingAnyHitCallIsNoticed) {
  Program p(simt_header());
  const traces::RayGroup group = uniform_group(32, {{{{LeafOutcome::inserted}}, {}, 0, 0}});
  p.program.begin(kSlot, group);
  p.any_hit(kAllLanes & ~LaneMask{1}, LeafOutcome::inserted, 0);
  p.program.blend(kSlot, p.phase);
  EXPECT_EQ(p.program.counters().k_buffer_mismatches, 1u);
}

TEST(ShaderProgramHeader, RefusesWarpsWiderThanTheMessages) {
  traces::Header header = simt_header();
  header.warp_size = 64;
  const MemoryMap map(header, {1, kResident, 0});
  EXPECT_THROW(ShaderProgram(header, map, ShaderCosts{}, 0, kResident), Error);
  header.warp_size = 0;
  EXPECT_THROW(ShaderProgram(header, map, ShaderCosts{}, 0, kResident), Error);
  for (const std::uint32_t narrow : {1u, kMaxLanes}) {
    header.warp_size = narrow;
    EXPECT_NO_THROW(ShaderProgram(header, map, ShaderCosts{}, 0, kResident)) << narrow;
  }
}

TEST(ShaderIntersection, ReadsAMatrixALaneUnlessTheRayIsInTheInstancesSpace) {
  for (const bool two_level : {false, true}) {
    traces::Header header = simt_header();
    header.accel = two_level ? traces::AccelKind::tlas_box : traces::AccelKind::box;
    header.two_level = two_level;
    Program p(header);
    ASSERT_TRUE(p.program.intersects());
    AnyHitBatch batch;
    batch.slot = kSlot;
    batch.lanes = 0x7;
    batch.outcome = {LeafOutcome::miss, LeafOutcome::inserted, LeafOutcome::beyond};
    batch.leaf = {2, 9, 2};
    p.program.intersection(batch, p.phase);
    EXPECT_EQ(p.phase.instructions, two_level ? 28u : 28u + 24u);
    // Matrices of 48 B at 96 and 432: sectors 3 and 4, 13 and 14; lane 2 shares those of lane 0.
    EXPECT_EQ(p.phase.loads.size(), two_level ? 0u : 4u);
    EXPECT_TRUE(p.phase.stores.empty());
    EXPECT_EQ(p.program.counters().intersection_calls, 3u);
    EXPECT_EQ(ShaderProgram::hits_of(batch).lanes, 0x2u);
  }
}

}  // namespace
}  // namespace grtx::modules
