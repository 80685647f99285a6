// SPDX-License-Identifier: Apache-2.0
// The memory hierarchy as a whole: latency formulas through all levels, conservation, and results that depend neither
// on the order of construction nor on idle skip.
#include <gmock/gmock.h>

#include <sstream>

#include "grtx/modules/cache/l2_slice.h"
#include "modules/cache/hierarchy_bench.h"

namespace grtx::modules {
namespace {

constexpr DramTiming kT{};

class Hierarchy : public SystemCTest {
 protected:
  /// Cycles from a request visible at the L1 to the response visible at its client.
  static Cycle l2_hit_latency(const HierarchyBench::Config& c) {
    const Cycle request = c.l1.tag_latency + 1 + c.crossbar.latency;  // tags, link to the crossbar, crossbar
    const Cycle reply = 1 + c.crossbar.latency + 1;  // link to the crossbar, crossbar, link to the client
    return request + c.l2.latency + reply;
  }
};

TEST_F(Hierarchy, LatencyOfEachLevel) {
  const HierarchyBench::Config config;
  HierarchyBench bench(config);
  MockClient& client = *bench.client[3];
  MockClient& elsewhere = *bench.client[10];  // another SM
  const auto dram_miss = client.read(100, 0x5000);
  const auto l1_hit = client.read(2000, 0x5000);
  const auto l2_hit = elsewhere.read(3000, 0x5000);
  const auto row_hit = elsewhere.read(4000, 0x5020);
  EXPECT_TRUE(run_until_quiet(bench.core, 20000));
  EXPECT_EQ(client.answered(l1_hit) - 2000, 20u);
  EXPECT_EQ(elsewhere.answered(l2_hit) - 3000, l2_hit_latency(config));
  EXPECT_EQ(l2_hit_latency(config), 185u);
  // A DRAM access adds the time from the L2's call to the fill: to the next memory edge, the DRAM, to the next core
  // edge.
  const auto with_dram = [&](Cycle visible, Cycle clocks) {
    const std::uint64_t core = bench.core.period_fs();
    const std::uint64_t memory = bench.memory.period_fs();
    const Cycle sent = visible + config.l1.tag_latency + 1 + config.crossbar.latency + config.l2.latency;
    const Cycle filled = (sent * core / memory + 1 + clocks) * memory / core + 1;
    return filled + 1 + config.crossbar.latency + 1;
  };
  EXPECT_EQ(client.answered(dram_miss), with_dram(100, kT.rcd + kT.cl + kT.ccd + 256));
  EXPECT_EQ(elsewhere.answered(row_hit), with_dram(4000, kT.cl + kT.ccd + 256));
  bench.expect_conserved();
}

TEST_F(Hierarchy, ResultsDoNotDependOnConstructionOrderOrIdleSkip) {
  const auto simulate = [](std::uint64_t order, bool idle_skip, bool checkers) {
    fresh_context();
    HierarchyBench::Config config;
    config.sms = 4;
    config.l1.clients = 3;
    config.l1.geometry = {8192, 128, 32, 16};
    config.l2.geometry = {16384, 128, 32, 8};
    config.l1.mshr_entries = 24;
    config.l2.mshr_entries = 12;
    config.l2.queue = 8;
    config.dram.channel.queue = 8;
    config.idle_skip = idle_skip;
    config.checkers = checkers;
    config.order = order;
    HierarchyBench bench(config);
    for (unsigned i = 0; i < bench.client.size(); ++i) {
      Random random(i);
      Cycle cycle = 10;
      for (unsigned n = 0; n < 600; ++n) {
        cycle += random.chance(90) ? random.below(3) : random.below(200);
        MemoryRequest r{.address = random.below(1 << 12) * kSectorBytes,
                        .region = static_cast<Region>(random.below(kRegionCount)),
                        .write = random.chance(25)};
        r.prefetch = !r.write && random.chance(10);
        bench.client[i]->at(cycle, r);
      }
      bench.client[i]->takes = [i](Cycle now) { return Random(i + now * 17).chance(70); };
    }
    run(bench.core, 40000);
    bench.expect_conserved();
    std::ostringstream result;
    const StatisticList list = bench.statistics();
    for (const Statistic& s : list.items()) {
      result << s.name << ' ';
      std::visit([&](auto value) { result << value << '\n'; }, s.value);
      EXPECT_FALSE(s.unit.empty()) << s.name;
      EXPECT_FALSE(s.description.empty()) << s.name;
    }
    for (const auto& c : bench.client) {
      for (const auto& a : c->answers()) result << a.cycle << ' ' << a.response.tag << '\n';
    }
    return result.str();
  };
  const std::string reference = simulate(0, true, true);
  EXPECT_EQ(reference, simulate(0, false, true)) << "idle skip";
  EXPECT_EQ(reference, simulate(0, true, false)) << "protocol checkers";
  for (std::uint64_t order = 1; order <= 5; ++order) {
    EXPECT_EQ(reference, simulate(order, true, true)) << "construction order " << order;
  }
}

TEST_F(Hierarchy, CoincidingEdgesOfTheTwoClocksDoNotDependOnTheOrderEither) {
  // With a 2:1 ratio every core edge is a memory edge, so every call across the boundary is a race if there are any.
  const auto simulate = [](bool core_first) {
    fresh_context();
    std::unique_ptr<ClockDomain> core, memory;
    if (core_first) core = std::make_unique<ClockDomain>("core", 1000.0);
    memory = std::make_unique<ClockDomain>("memory", 2000.0);
    if (!core_first) core = std::make_unique<ClockDomain>("core", 1000.0);
    PortLinks links("client", 64);
    L2Slice::Config config;
    config.interleave.slices = 1;
    config.geometry = {4096, 128, 32, 4};
    config.latency = 5;
    Dram::Config dram_config;
    dram_config.interleave = config.interleave;
    dram_config.channel.queue = 4;
    dram_config.fixed_latency = 2;
    std::unique_ptr<L2Slice> l2;
    std::unique_ptr<Dram> dram;
    if (core_first) l2 = std::make_unique<L2Slice>("l2", config, *core);
    dram = std::make_unique<Dram>("dram", dram_config, *memory);
    if (!core_first) l2 = std::make_unique<L2Slice>("l2", config, *core);
    MockClient client("client", *core, links);
    l2->request.bind(links.request);
    l2->response.bind(links.response);
    l2->dram.socket.bind(dram->sockets[0]);
    Random random(5);
    Cycle cycle = 10;
    for (unsigned i = 0; i < 1000; ++i) {
      client.at(cycle += random.below(4), {.address = random.below(1024) * 32, .write = random.chance(40)});
    }
    EXPECT_TRUE(run_until_quiet(*core, 100000));
    EXPECT_TRUE(client.complete());
    std::vector<Cycle> trace;
    for (const auto& a : client.answers()) trace.push_back(a.cycle);
    trace.push_back(dram->counters().channel.full_clocks);
    return trace;
  };
  EXPECT_EQ(simulate(true), simulate(false));
}

TEST_F(Hierarchy, WorksWithOddNumbersOfSlicesAndTheXorHash) {
  for (const AddressInterleave interleave : {AddressInterleave{.slices = 3}, AddressInterleave{.slices = 1},
                                             AddressInterleave{.slices = 8, .xor_hash = true}}) {
    fresh_context();
    HierarchyBench::Config config;
    config.sms = 2;
    config.interleave = interleave;
    config.l1.geometry = {4096, 128, 32, 8};
    config.l2.geometry = {8192, 128, 32, 16};
    HierarchyBench bench(config);
    for (unsigned i = 0; i < bench.client.size(); ++i) {
      Random random(i);
      for (unsigned n = 0; n < 500; ++n) {
        bench.client[i]->at(10 + n, {.address = random.below(4096) * 32, .write = random.chance(30)});
      }
    }
    EXPECT_TRUE(run_until_quiet(bench.core, 100000));
    bench.expect_conserved();
  }
}

TEST_F(Hierarchy, InventoriesAreMadeOfTheSimulatedParameters) {
  const HierarchyBench bench({});
  const auto bits = [](const Inventory& inventory, const char* name) {
    for (const Storage& s : inventory.storage) {
      if (s.name == name) return s.bits;
    }
    return std::uint64_t{0};
  };
  EXPECT_EQ(bits(bench.l1[0]->inventory(), "data"), 128u * 1024 * 8);
  EXPECT_EQ(bits(bench.l2[0]->inventory(), "data"), 1024u * 1024 * 8);
  EXPECT_EQ(bench.l1[0]->inventory().module, "l1_0");
  EXPECT_FALSE(bench.crossbar->inventory().operators.empty());
  EXPECT_GT(bits(bench.dram->inventory(), "queues"), 0u);
}

TEST_F(Hierarchy, StateDumpsNameWhatIsStuck) {
  HierarchyBench bench({});
  bench.client[0]->read(10, 0x1000);
  run(bench.core, 250);
  std::ostringstream dump;
  bench.l1[0]->dump_state(dump);
  bench.crossbar->dump_state(dump);
  bench.l2[0]->dump_state(dump);
  bench.dram->dump_state(dump);
  EXPECT_THAT(dump.str(), ::testing::HasSubstr("sector 0x1000 since cycle 10"));
  EXPECT_THAT(dump.str(), ::testing::HasSubstr("dram outstanding 1"));
  EXPECT_FALSE(bench.l1[0]->idle());
  EXPECT_TRUE(run_until_quiet(bench.core, 2000));
  EXPECT_TRUE(bench.l1[0]->idle());
}

}  // namespace
}  // namespace grtx::modules
