// SPDX-License-Identifier: Apache-2.0
// LinkToTlm: a module that asks for links is answered by a TLM-2.0 memory, approximately or loosely timed.
#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/dram/dram.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "grtx/modules/tlm/link_to_tlm.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

/// A blocking memory: a delay is returned, or waited for.
class LtMemory final : public sc_core::sc_module, public ::tlm::tlm_fw_transport_if<> {
 public:
  LtMemory(const sc_core::sc_module_name& name, const sc_core::sc_time& latency, bool waits)
      : sc_module(name), socket("socket"), latency_(latency), waits_(waits) {
    socket.bind(*this);
  }
  ::tlm::tlm_target_socket<32> socket;  // no convenience socket that would convert non-blocking calls
  std::uint64_t calls = 0;
  std::uint64_t limit = ~std::uint64_t{0};

 private:
  void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) override {
    ++calls;
    payload.set_response_status(payload.get_address() < limit ? ::tlm::TLM_OK_RESPONSE
                                                              : ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
    if (waits_) {
      sc_core::wait(latency_);
    } else {
      delay += latency_;
    }
  }
  ::tlm::tlm_sync_enum nb_transport_fw(::tlm::tlm_generic_payload&, ::tlm::tlm_phase&, sc_core::sc_time&) override {
    ADD_FAILURE() << "this memory is loosely timed";
    return ::tlm::TLM_COMPLETED;
  }
  bool get_direct_mem_ptr(::tlm::tlm_generic_payload&, ::tlm::tlm_dmi&) override { return false; }
  unsigned transport_dbg(::tlm::tlm_generic_payload&) override { return 0; }

  sc_core::sc_time latency_;
  bool waits_;
};

class LinkBridge : public SystemCTest {
 protected:
  struct Bench {
    explicit Bench(LinkToTlm::Config config = {})
        : core("core", 1365.0), links("port"), client("client", core, links), bridge("bridge", config, core) {
      bridge.request.bind(links.request);
      bridge.response.bind(links.response);
    }
    ClockDomain core;
    PortLinks links;
    MockClient client;
    LinkToTlm bridge;
  };
};

TEST_F(LinkBridge, UnloadedLatencyThroughTheDramIsTheFormula) {
  Bench bench;
  ClockDomain memory("memory", 3500.0);
  Dram::Config config;
  config.interleave.slices = 1;
  Dram dram("dram", config, memory);
  AtProtocolChecker checker("checker", {.period_fs = bench.core.period_fs()});
  bench.bridge.memory.socket.bind(checker.target);
  checker.initiator.bind(dram.sockets[0]);
  const auto miss = bench.client.read(100, 0x4000);
  const auto hit = bench.client.write(2000, 0x4020);
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  const DramTiming t{};
  const auto expected = [&](Cycle visible, Cycle clocks) {
    const std::uint64_t c = bench.core.period_fs();
    const std::uint64_t m = memory.period_fs();
    return (visible * c / m + 1 + clocks) * m / c + 1 + 1;  // memory edge, DRAM, core edge, link
  };
  EXPECT_EQ(bench.client.answered(miss), expected(100, t.rcd + t.cl + t.ccd + 256));
  EXPECT_EQ(bench.client.answered(hit), expected(2000, t.wl + t.ccd + 256));
  EXPECT_EQ(checker.violations(), 0u);
  EXPECT_TRUE(bench.bridge.idle());
}

TEST_F(LinkBridge, ALooselyTimedMemoryAnswersAfterItsDelayOrItsWait) {
  for (const bool waits : {false, true}) {
    fresh_context();
    Bench bench({.blocking = true});
    LtMemory memory("memory", sc_core::sc_time(50, sc_core::SC_NS), waits);
    bench.bridge.memory.socket.bind(memory.socket);
    std::vector<std::uint32_t> tags;
    for (unsigned i = 0; i < 20; ++i) tags.push_back(bench.client.read(100 + i, i * 32));
    EXPECT_TRUE(run_until_quiet(bench.core, 10000));
    EXPECT_TRUE(bench.client.complete());
    EXPECT_EQ(memory.calls, 20u);
    const std::uint64_t period = bench.core.period_fs();
    Cycle sent = 100;
    for (unsigned i = 0; i < 20; ++i) {
      const Cycle visible = (sent * period + 50'000'000) / period + 1;
      EXPECT_EQ(bench.client.answered(tags[i]), visible + 1) << "waits " << waits << ", " << i;
      sent = waits ? visible : sent + 1;  // one call at a time; calls that return at once follow each other
    }
    EXPECT_TRUE(bench.bridge.idle());
  }
}

TEST_F(LinkBridge, EveryHabitOfATargetAndAFullResponseLink) {
  for (const AtBehaviour behaviour :
       {AtBehaviour::plain, AtBehaviour::withheld, AtBehaviour::no_end_request, AtBehaviour::updated,
        AtBehaviour::updated_response, AtBehaviour::completed, AtBehaviour::annotated, AtBehaviour::out_of_order}) {
    fresh_context();
    Bench bench({.outstanding = 6});
    ClockDomain memory("memory", 3500.0);
    MockAtTarget target("target", memory, behaviour);
    bench.bridge.memory.socket.bind(target.socket);
    bench.client.takes = [](Cycle now) { return now % 16 == 0; };
    for (unsigned i = 0; i < 60; ++i)
      bench.client.at(100, {.address = i * 32, .region = Region::leaf, .write = i % 3 == 0});
    EXPECT_TRUE(run_until_quiet(bench.core, 100000));
    EXPECT_TRUE(bench.client.complete());
    for (const auto& answer : bench.client.answers()) {
      EXPECT_EQ(answer.response.address, answer.response.tag * 32);
      EXPECT_EQ(answer.response.region, Region::leaf);
      EXPECT_EQ(answer.response.write, answer.response.tag % 3 == 0);
    }
    EXPECT_TRUE(bench.bridge.idle());
  }
}

TEST_F(LinkBridge, AnErrorStatusEndsTheSimulationWithAReportThatNamesSocketAndAddress) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP()
      << "an exception that crosses SystemC's stacks is a false report (github.com/google/sanitizers, issue 189)";
#endif
  Bench bench({.blocking = true});
  LtMemory memory("memory", sc_core::sc_time(50, sc_core::SC_NS), false);
  memory.limit = 0x1000;
  bench.bridge.memory.socket.bind(memory.socket);
  bench.client.read(100, 0x2000);
  try {
    run(bench.core, 1000);
    FAIL() << "the error was not reported";
  } catch (const sc_core::sc_report& report) {
    EXPECT_STREQ(report.get_msg_type(), AtInitiator::kReport);
    EXPECT_STREQ(report.get_msg(),
                 "bridge.memory: address 0x2000: the memory answered a read with TLM_ADDRESS_ERROR_RESPONSE");
  }
}

TEST_F(LinkBridge, EachLaunchBehindABridgeTakesTheSameCycles) {
  for (const bool blocking : {false, true}) {
    fresh_context();
    Bench bench({.outstanding = 2, .blocking = blocking});
    ClockDomain memory("memory", 3500.0);
    Dram::Config config;
    config.interleave.slices = 1;
    Dram dram("dram", config, memory);
    bench.bridge.memory.socket.bind(dram.sockets[0]);
    std::vector<Cycle> took;
    for (unsigned launch = 0; launch < 3; ++launch) {
      std::uint32_t tag = 0;
      for (unsigned i = 0; i < 8; ++i) tag = bench.client.read(100, i * 4096);
      EXPECT_TRUE(run_until_quiet(bench.core, 100'000));
      took.push_back(bench.client.answered(tag));
      EXPECT_EQ(bench.bridge.requests(), 8u);
      bench.core.restart(Caches::cold);
      memory.restart(Caches::cold);
    }
    EXPECT_EQ(took, std::vector<Cycle>(3, took[0])) << "blocking " << blocking;
    EXPECT_NE(took[0], kNever);
  }
}

}  // namespace
}  // namespace grtx::modules
