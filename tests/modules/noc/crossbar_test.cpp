// SPDX-License-Identifier: Apache-2.0
// Crossbar: exact latency, one packet per port and cycle, round robin, routing, back-pressure without loss.
#include "grtx/modules/noc/crossbar.h"

#include <gmock/gmock.h>

#include "grtx/base/error.h"
#include "modules/memory_mocks.h"

namespace grtx::modules {
namespace {

using ::testing::ElementsAre;

class CrossbarTest : public SystemCTest {
 protected:
  /// SMs are mock clients, slices are mock memories that answer after `latency` cycles.
  struct Bench {
    explicit Bench(Crossbar::Config config, Cycle latency = 10, std::size_t capacity = 8, bool idle_skip = true)
        : clock("clock", 1365.0, idle_skip), crossbar("crossbar", config, clock) {
      for (unsigned i = 0; i < config.sms; ++i) {
        const std::string name = "sm" + std::to_string(i);
        sm_links.push_back(std::make_unique<PortLinks>(name, capacity));
        crossbar.request_in[i].bind(sm_links[i]->request);
        crossbar.response_out[i].bind(sm_links[i]->response);
        sms.push_back(std::make_unique<MockClient>(name, clock, *sm_links[i]));
      }
      for (unsigned i = 0; i < config.interleave.slices; ++i) {
        const std::string name = "slice" + std::to_string(i);
        slice_links.push_back(std::make_unique<PortLinks>(name, capacity));
        crossbar.request_out[i].bind(slice_links[i]->request);
        crossbar.response_in[i].bind(slice_links[i]->response);
        slices.push_back(
            std::make_unique<MockMemory>(name, clock, slice_links[i]->request, slice_links[i]->response, latency));
      }
    }
    std::uint32_t read(unsigned sm, Cycle visible, std::uint64_t address) {
      return sms[sm]->at(visible, {.address = address, .sm = static_cast<std::uint8_t>(sm)});
    }
    ClockDomain clock;
    Crossbar crossbar;
    std::vector<std::unique_ptr<PortLinks>> sm_links;
    std::vector<std::unique_ptr<PortLinks>> slice_links;
    std::vector<std::unique_ptr<MockClient>> sms;
    std::vector<std::unique_ptr<MockMemory>> slices;
  };
  static Crossbar::Config config_of(unsigned sms, unsigned slices, unsigned latency = 8) {
    Crossbar::Config config;
    config.sms = sms;
    config.interleave.slices = slices;
    config.latency = latency;
    return config;
  }
};

TEST_F(CrossbarTest, UnloadedLatencyIsExactEachWay) {
  for (const unsigned latency : {1u, 2u, 8u, 25u}) {
    fresh_context();
    Bench bench(config_of(2, 4, latency), 10);
    const auto tag = bench.read(1, 100, 3 * 256);
    EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
    ASSERT_EQ(bench.slices[3]->arrivals().size(), 1u);
    EXPECT_EQ(bench.slices[3]->arrivals()[0].cycle, 100 + latency);
    EXPECT_EQ(bench.sms[1]->answered(tag), 100 + latency + 10 + latency);
  }
}

TEST_F(CrossbarTest, AddressesInterleaveOverTheSlices) {
  Bench bench(config_of(1, 4));
  for (unsigned i = 0; i < 32; ++i) bench.read(0, 10 + i, i * 128);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  for (unsigned s = 0; s < 4; ++s) {
    EXPECT_EQ(bench.slices[s]->arrivals().size(), 8u);
    for (const auto& a : bench.slices[s]->arrivals()) EXPECT_EQ(a.request.address / 256 % 4, s);
  }
}

TEST_F(CrossbarTest, PortsCarryOnePacketACycleInParallel) {
  Bench bench(config_of(4, 4));
  for (unsigned i = 0; i < 50; ++i) {
    for (unsigned sm = 0; sm < 4; ++sm) bench.read(sm, 100 + i, ((sm + i) % 4) * 256);  // a permutation every cycle
  }
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  for (unsigned s = 0; s < 4; ++s) EXPECT_EQ(bench.slices[s]->arrivals().back().cycle, 100u + 49 + 8);
  EXPECT_EQ(bench.crossbar.counters().request.conflict_cycles, 0u);
}

TEST_F(CrossbarTest, OneOutputIsSharedRoundRobin) {
  Bench bench(config_of(3, 2));
  for (unsigned i = 0; i < 3; ++i) {
    for (unsigned sm = 0; sm < 3; ++sm) bench.read(sm, 100, 256);
  }
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  std::vector<unsigned> order;
  for (const auto& a : bench.slices[1]->arrivals()) order.push_back(a.request.sm);
  EXPECT_THAT(order, ElementsAre(0, 1, 2, 0, 1, 2, 0, 1, 2));
  EXPECT_EQ(bench.slices[1]->arrivals().back().cycle, 100u + 8 + 8);
  // Three contenders for seven cycles (each input holds three), then two, then one.
  EXPECT_EQ(bench.crossbar.counters().request.conflict_cycles, 7u * 2 + 1);
}

TEST_F(CrossbarTest, ABlockedOutputHoldsUpItsInputsAndNoOthers) {
  Bench bench(config_of(2, 2), 10, 4);
  bench.slices[0]->takes = [](Cycle now) { return now >= 500; };
  for (unsigned i = 0; i < 80; ++i) bench.read(0, 100 + i, 0);
  for (unsigned i = 0; i < 80; ++i) bench.read(1, 100 + i, 256);
  run(bench.clock, 400);
  EXPECT_EQ(bench.sms[1]->answers().size(), 80u);
  EXPECT_TRUE(bench.sms[0]->answers().empty());
  EXPECT_GT(bench.crossbar.counters().request.blocked_cycles, 100u);
  EXPECT_TRUE(run_until_quiet(bench.clock, 1000));
  EXPECT_TRUE(bench.sms[0]->complete());
  EXPECT_TRUE(bench.crossbar.idle());
}

TEST_F(CrossbarTest, RandomTrafficWithRandomBackPressureIsConserved) {
  const auto simulate = [](std::uint64_t seed, bool idle_skip) {
    fresh_context();
    Crossbar::Config config = config_of(5, 4);
    config.output_buffer = 2;
    config.interleave.xor_hash = seed % 2 == 0;
    Bench bench(config, 30, 3, idle_skip);
    Random random(seed);
    const auto sometimes = [seed](unsigned salt) {
      return [seed, salt](Cycle now) { return Random(seed * 101 + now * 7 + salt).chance(60); };
    };
    for (unsigned s = 0; s < 4; ++s) bench.slices[s]->takes = sometimes(s);
    for (unsigned sm = 0; sm < 5; ++sm) {
      bench.sms[sm]->takes = sometimes(10 + sm);
      Cycle cycle = 10;
      for (unsigned i = 0; i < 400; ++i) bench.read(sm, cycle += random.below(4), random.below(4096) * 32);
    }
    run(bench.clock, 10000);
    std::vector<Cycle> trace;
    for (unsigned sm = 0; sm < 5; ++sm) {
      EXPECT_TRUE(bench.sms[sm]->complete());
      for (const auto& a : bench.sms[sm]->answers()) {
        EXPECT_EQ(a.response.sm, sm);
        trace.push_back(a.cycle);
      }
    }
    const CrossbarCounters c = bench.crossbar.counters();
    EXPECT_EQ(c.request.packets_out, 2000u);
    EXPECT_EQ(c.reply.packets_out, 2000u);
    EXPECT_TRUE(bench.crossbar.idle());
    trace.push_back(c.request.conflict_cycles);
    trace.push_back(c.request.blocked_cycles);
    trace.push_back(c.reply.conflict_cycles);
    trace.push_back(c.reply.blocked_cycles);
    return trace;
  };
  for (std::uint64_t seed = 1; seed <= 4; ++seed) EXPECT_EQ(simulate(seed, true), simulate(seed, false));
}

TEST_F(CrossbarTest, CountsOfAUsersCrossbarAreStatistics) {
  CrossbarCounters counters;
  counters.own.add("hops", 7, "packet-hops", "of packets", 0.5);
  StatisticList list;
  describe(counters, list, "gpu.crossbar");
  const Statistic& last = list.items().back();
  EXPECT_EQ(last.name, "gpu.crossbar.hops");
  EXPECT_EQ(std::get<std::uint64_t>(last.value), 7u);
  EXPECT_EQ(last.picojoules, 0.5);
}

TEST_F(CrossbarTest, ImpossibleConfigurationsAreRefused) {
  ClockDomain clock("clock", 1365.0);
  EXPECT_THROW(Crossbar("a", config_of(0, 4), clock), Error);
  EXPECT_THROW(Crossbar("b", config_of(1, 0), clock), Error);
  EXPECT_THROW(Crossbar("c", config_of(1, 1, 0), clock), Error);
}

}  // namespace
}  // namespace grtx::modules
