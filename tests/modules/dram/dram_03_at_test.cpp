// SPDX-License-Identifier: Apache-2.0
// Dram behind its AT socket: exact latency across the two clocks, peak bandwidth, back-pressure, errors, `perfect`.
#include "grtx/modules/dram/dram.h"
#include "grtx/modules/tlm/at_payload_pool.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

class DramAt : public SystemCTest {
 protected:
  struct Bench {
    explicit Bench(Dram::Config config = {}, bool idle_skip = true)
        : core("core", 1365.0, idle_skip), memory("memory", 3500.0, idle_skip), dram("dram", config, memory) {
      for (unsigned i = 0; i < config.interleave.slices; ++i) {
        const std::string n = std::to_string(i);
        drivers.push_back(std::make_unique<AtDriver>(("driver" + n).c_str(), core));
        checkers.push_back(std::make_unique<AtProtocolChecker>(
            ("checker" + n).c_str(), AtProtocolChecker::Config{.period_fs = core.period_fs()}));
        drivers[i]->initiator.socket.bind(checkers[i]->target);
        checkers[i]->initiator.bind(dram.sockets[i]);
      }
    }
    ~Bench() {
      for (const auto& c : checkers) {
        EXPECT_EQ(c->violations(), 0u) << c->messages().front();
        EXPECT_EQ(c->outstanding(), 0u);
      }
      for (const auto& d : drivers) EXPECT_TRUE(d->complete());
      EXPECT_TRUE(dram.idle());
    }
    /// Core cycle that sees the response of a request sent in `cycle` and done `clocks` after its arrival.
    Cycle expected(Cycle cycle, Cycle clocks) const {
      const Cycle arrival = cycle * core.period_fs() / memory.period_fs() + 1;
      return (arrival + clocks) * memory.period_fs() / core.period_fs() + 1;
    }
    ClockDomain core;
    ClockDomain memory;
    Dram dram;
    std::vector<std::unique_ptr<AtDriver>> drivers;
    std::vector<std::unique_ptr<AtProtocolChecker>> checkers;
  };
  static constexpr DramTiming kT{};
  static Dram::Config one_channel() {
    Dram::Config config;
    config.interleave.slices = 1;
    return config;
  }
};

TEST_F(DramAt, LatencyOfMissHitAndConflict) {
  Bench bench(one_channel());
  AtDriver& driver = *bench.drivers[0];
  const auto miss = driver.at(100, 0);
  const auto hit = driver.at(1000, 32);
  const auto conflict = driver.at(2000, 16 * 2048);
  const auto write = driver.at(3000, 16 * 2048 + 32, true);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(driver.answered(miss), bench.expected(100, kT.rcd + kT.cl + kT.ccd + 256));
  EXPECT_EQ(driver.answered(hit), bench.expected(1000, kT.cl + kT.ccd + 256));
  EXPECT_EQ(driver.answered(conflict), bench.expected(2000, kT.rp + kT.rcd + kT.cl + kT.ccd + 256));
  EXPECT_EQ(driver.answered(write), bench.expected(3000, kT.wl + kT.ccd + 256));
}

TEST_F(DramAt, StreamingReachesThePeakOf28GigabytesPerSecond) {
  Bench bench(one_channel());
  constexpr unsigned kRequests = 4000;
  for (unsigned i = 0; i < kRequests; ++i) bench.drivers[0]->at(10, i * 32);
  EXPECT_TRUE(run_until_quiet(bench.core, 100000));
  const Cycle first = bench.drivers[0]->answers().front().cycle;
  const Cycle last = bench.drivers[0]->answers().back().cycle;
  const double seconds = static_cast<double>((last - first) * bench.core.period_fs()) * 1e-15;
  const double rate = (kRequests - 1) * 32 / seconds * 1e-9;
  EXPECT_NEAR(rate, 28.0, 28.0 * 0.01) << "GB/s";
  EXPECT_EQ(bench.dram.counters().channel.row_misses + bench.dram.counters().channel.row_conflicts,
            (kRequests * 32 + 2047) / 2048);
}

TEST_F(DramAt, ChannelsWorkInParallel) {
  Bench bench;
  constexpr unsigned kRequests = 4000;
  for (unsigned i = 0; i < kRequests; ++i) {
    const std::uint64_t address = i * 32;
    bench.drivers[bench.dram.config().interleave.slice(address)]->at(10, address);
  }
  EXPECT_TRUE(run_until_quiet(bench.core, 100000));
  Cycle last = 0;
  for (const auto& d : bench.drivers) last = std::max(last, d->answers().back().cycle);
  const double seconds = static_cast<double>(last * bench.core.period_fs()) * 1e-15;
  EXPECT_GT(kRequests * 32 / seconds * 1e-9, 100.0) << "GB/s of a peak of 112, latency included";
  for (unsigned c = 0; c < 4; ++c) EXPECT_EQ(bench.dram.channel_counters(c).bytes, kRequests * 32 / 4);
}

TEST_F(DramAt, SlicesThatShareAChannelTakeTurns) {
  Dram::Config config;
  config.interleave.slices = 4;
  config.interleave.channels = 2;
  Bench bench(config);
  constexpr unsigned kRequests = 2000;  // of a slice
  for (unsigned slice = 0; slice < 4; ++slice) {
    for (unsigned i = 0; i < kRequests; ++i) bench.drivers[slice]->at(10, config.interleave.global(i * 32, slice));
  }
  EXPECT_TRUE(run_until_quiet(bench.core, 100000));
  ASSERT_EQ(bench.dram.channels(), 2U);
  for (unsigned c = 0; c < 2; ++c) EXPECT_EQ(bench.dram.channel_counters(c).bytes, 2 * kRequests * 32);
  const auto first = bench.drivers[0]->answers().front().cycle, last = bench.drivers[0]->answers().back().cycle;
  const double seconds = static_cast<double>((last - first) * bench.core.period_fs()) * 1e-15;
  EXPECT_NEAR(2 * kRequests * 32 / seconds * 1e-9, 28.0, 28.0 * 0.02) << "GB/s of a channel, half of it each slice's";
  EXPECT_NEAR(static_cast<double>(bench.drivers[2]->answers().back().cycle), static_cast<double>(last), 20.0);
}

// A response finds its socket by the address.
TEST_F(DramAt, AnAddressOfAnotherSliceIsRefusedWhereSlicesShareAChannel) {
  Dram::Config config;
  config.interleave.slices = 2;
  config.interleave.channels = 1;
  fresh_context();
  ClockDomain memory("memory", 3500.0);
  RawAtInitiator first("first"), second("second");
  Dram dram("dram", config, memory);
  first.socket.bind(dram.sockets[0]);
  second.socket.bind(dram.sockets[1]);
  AtPayload& payload = first.payload(256);
  TickProcess starter("starter", memory, [&](Cycle now) {
    if (now == 10) first.send(payload);
  });
  memory.request(10);
  EXPECT_TRUE(run_until_quiet(memory, 20000));
  EXPECT_EQ(payload.get_response_status(), ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
}

TEST_F(DramAt, AFullQueueWithholdsEndRequest) {
  Dram::Config config = one_channel();
  config.channel.queue = 4;
  Bench bench(config);
  for (unsigned i = 0; i < 40; ++i) bench.drivers[0]->at(10, i * 16 * 2048);  // all conflicts of one bank
  EXPECT_TRUE(run_until_quiet(bench.core, 100000));
  EXPECT_GT(bench.dram.counters().channel.full_clocks, 1000u);
  // At most four wait and none overtakes: 40 row cycles of RAS + RP clocks (RC is shorter).
  const Cycle clocks = 39 * (kT.ras + kT.rp) + kT.rcd + kT.cl + kT.ccd + 256;
  EXPECT_EQ(bench.drivers[0]->answers().back().cycle, bench.expected(10, clocks));
}

TEST_F(DramAt, MalformedTransactionsAreRefusedNotLost) {
  Dram::Config config = one_channel();
  config.bytes = 1 << 20;
  fresh_context();
  ClockDomain memory("memory", 3500.0);
  RawAtInitiator initiator("initiator");
  Dram dram("dram", config, memory);
  initiator.socket.bind(dram.sockets[0]);
  struct Case {
    std::uint64_t address;
    unsigned length;
    ::tlm::tlm_response_status status;
  };
  const Case cases[] = {{0, 32, ::tlm::TLM_OK_RESPONSE},
                        {0, 96, ::tlm::TLM_BURST_ERROR_RESPONSE},
                        {0, 512, ::tlm::TLM_BURST_ERROR_RESPONSE},
                        {16, 32, ::tlm::TLM_ADDRESS_ERROR_RESPONSE},
                        {1 << 20, 32, ::tlm::TLM_ADDRESS_ERROR_RESPONSE}};
  std::vector<AtPayload*> payloads;
  TickProcess starter("starter", memory, [&](Cycle now) {
    if (now % 1000 != 0 || payloads.size() == std::size(cases)) return;
    const Case& c = cases[payloads.size()];
    AtPayload& payload = initiator.payload(c.address);
    payload.set_data_length(c.length);
    payload.set_streaming_width(c.length);
    payloads.push_back(&payload);
    initiator.send(payload);
    memory.request(now + 1000);
  });
  memory.request(1000);
  EXPECT_TRUE(run_until_quiet(memory, 20000));
  for (std::size_t i = 0; i < std::size(cases); ++i) {
    EXPECT_EQ(payloads[i]->get_response_status(), cases[i].status) << i;
  }
  EXPECT_EQ(dram.counters().channel.refused, 4u);
  EXPECT_TRUE(dram.idle());
}

TEST_F(DramAt, PerfectAnswersEverythingAfterTheFixedLatency) {
  Dram::Config config = one_channel();
  config.perfect = true;
  Bench bench(config);
  for (unsigned i = 0; i < 20; ++i) bench.drivers[0]->at(10 + 3 * i, i * 16 * 2048);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  for (unsigned i = 0; i < 20; ++i) EXPECT_EQ(bench.drivers[0]->answered(i), bench.expected(10 + 3 * i, 256));
  EXPECT_EQ(bench.dram.counters().channel.bytes, 640u);
}

TEST_F(DramAt, RandomTrafficIsConservedAndIdleSkipChangesNothing) {
  using Trace = std::vector<std::pair<Cycle, std::uint32_t>>;
  const auto simulate = [](std::uint64_t seed, bool idle_skip) {
    fresh_context();
    Dram::Config config;
    config.interleave.slices = 2;
    config.channel.queue = 8;
    config.channel.age_cap = 200;
    config.fixed_latency = seed % 2 == 0 ? 0 : 256;
    Bench bench(config, idle_skip);
    Random random(seed);
    Cycle cycle = 5;
    for (unsigned i = 0; i < 1500; ++i) {
      cycle += random.below(random.chance(3) ? 500 : 4);
      const std::uint64_t address = random.below(1 << 15) * 128;
      bench.drivers[config.interleave.slice(address)]->at(cycle, address, random.chance(30),
                                                          random.chance(20) ? 128 : 32);
    }
    run(bench.core, 100000);
    Trace trace;
    for (const auto& d : bench.drivers) {
      for (const auto& a : d->answers()) trace.emplace_back(a.cycle, a.completion.context);
    }
    const DramCounters c = bench.dram.counters();
    EXPECT_EQ(c.channel.reads + c.channel.writes, 1500u);
    EXPECT_EQ(c.channel.responses, 1500u);
    EXPECT_EQ(c.channel.row_hits + c.channel.row_misses + c.channel.row_conflicts, 1500u);
    EXPECT_GT(c.channel.full_clocks, 0u);
    trace.emplace_back(c.channel.full_clocks, 0);
    trace.emplace_back(c.channel.queue_clocks, 0);
    return trace;
  };
  for (std::uint64_t seed = 1; seed <= 4; ++seed) EXPECT_EQ(simulate(seed, true), simulate(seed, false));
}

TEST_F(DramAt, AnEndRespWithoutABeginRespChangesNothingWhereReportsDoNotThrow) {
  ClockDomain memory("memory", 3500.0);
  Dram dram("dram", one_channel(), memory);
  RawAtInitiator initiator("initiator");
  initiator.socket.bind(dram.sockets[0]);
  run(memory, 1);
  AtPayload& first = initiator.payload(0);
  AtPayload& second = initiator.payload(32);
  sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_DO_NOTHING);
  initiator.send(first, tlm::END_RESP);
  initiator.send(first);
  initiator.send(second);  // before END_REQ of the first
  sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_DEFAULT_ERROR_ACTIONS);
  EXPECT_EQ(second.get_response_status(), ::tlm::TLM_GENERIC_ERROR_RESPONSE);
  EXPECT_TRUE(run_until_quiet(memory, 10000));
  EXPECT_EQ(first.get_response_status(), ::tlm::TLM_OK_RESPONSE);
  EXPECT_TRUE(dram.idle());
}

TEST_F(DramAt, AnAddressWhoseEndWrapsAroundIsRefused) {
  ClockDomain memory("memory", 3500.0);
  Dram::Config config = one_channel();
  config.bytes = std::uint64_t{1} << 20;
  Dram dram("dram", config, memory);
  RawAtInitiator initiator("initiator");
  initiator.socket.bind(dram.sockets[0]);
  run(memory, 1);
  AtPayload& payload = initiator.payload(~std::uint64_t{0} - 31);
  initiator.send(payload);
  EXPECT_TRUE(run_until_quiet(memory, 10000));
  EXPECT_EQ(payload.get_response_status(), ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
}

}  // namespace
}  // namespace grtx::modules
