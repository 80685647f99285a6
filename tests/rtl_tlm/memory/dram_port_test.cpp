// SPDX-License-Identifier: Apache-2.0
// DramPort between a requester at 1365 MHz and a memory whose clock is incommensurate: one answer each, back-pressure,
// fixed latency, refusals, counts.
#include "grtx/rtl_tlm/memory/dram_port.h"

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::sim {
namespace {

using modules::kNever;

/// Takes a request every `gap` clocks and answers it `latency` clocks later, every third one `late` clocks more.
class Device final : public modules::ClockedModule {
 public:
  Device(const sc_core::sc_module_name& name, modules::ClockDomain& clock, const DramPort::Config& config, Cycle gap,
         Cycle latency, Cycle late)
      : ClockedModule(name, clock), port("socket", config, clock, alarm_), gap_(gap), latency_(latency), late_(late) {}

  Cycle tick(Cycle now) override {
    for (std::size_t i = 0; i < inside_.size();) {
      if (inside_[i].done > now) {
        ++i;
        continue;
      }
      port.complete(*inside_[i].payload, now, true);
      inside_.erase(inside_.begin() + static_cast<std::ptrdiff_t>(i));
    }
    Cycle due = kNever;
    if (port.arrived(now) != nullptr) {
      if (now >= free_from_) {
        inside_.push_back({&port.accept(now), now + latency_ + (++taken % 3 == 0 ? late_ : 0)});
        free_from_ = now + gap_;
      } else {
        due = free_from_;
      }
    }
    for (const Inside& i : inside_) due = std::min(due, std::max(i.done, now + 1));
    return std::min(due, port.step(now));
  }

  DramPort port;
  std::uint64_t taken = 0;

 private:
  struct Inside {
    ::tlm::tlm_generic_payload* payload;
    Cycle done;
  };
  Cycle gap_;
  Cycle latency_;
  Cycle late_;
  Cycle free_from_ = 0;
  std::vector<Inside> inside_;
};

class DramPortAt : public modules::SystemCTest {
 protected:
  struct Bench {
    explicit Bench(const DramPort::Config& config, double memory_mhz = 1e6 / 570, Cycle gap = 1, Cycle latency = 20,
                   Cycle late = 0)
        : core("core", 1365.0),
          memory("memory", memory_mhz),
          driver("driver", core),
          checker("checker", modules::AtProtocolChecker::Config{.period_fs = core.period_fs()}),
          device("device", memory, config, gap, latency, late) {
      driver.initiator.socket.bind(checker.target);
      checker.initiator.bind(device.port.socket);
    }
    ~Bench() {
      EXPECT_EQ(checker.violations(), 0u) << checker.messages().front();
      EXPECT_EQ(checker.outstanding(), 0u);
      EXPECT_TRUE(driver.complete());
      EXPECT_TRUE(device.port.idle());
    }
    modules::ClockDomain core;
    modules::ClockDomain memory;
    modules::AtDriver driver;
    modules::AtProtocolChecker checker;
    Device device;
  };
};

TEST_F(DramPortAt, EachRequestHasOneAnswerWhateverTheOrder) {
  Bench bench({}, 1e6 / 570, 1, 20, 100);
  for (unsigned i = 0; i < 300; ++i) bench.driver.at(1, i * 32, i % 4 == 0);
  EXPECT_TRUE(run_until_quiet(bench.core, 100'000));
  const DramPortCounters& c = bench.device.port.counters();
  EXPECT_EQ(c.reads, 225u);
  EXPECT_EQ(c.writes, 75u);
  EXPECT_EQ(c.bytes, 300u * 32);
  EXPECT_EQ(c.responses, 300u);
  EXPECT_EQ(c.inside_clocks, 300u * 20 + 100u * 100);
}

TEST_F(DramPortAt, EndReqIsWithheldUntilTheDeviceTakesTheRequest) {
  Bench bench({}, 1000.0, 50);
  bench.driver.at(10, 0);
  bench.driver.at(10, 32);
  EXPECT_TRUE(run_until_quiet(bench.core, 100'000));
  // The first request enters at the first memory edge after core cycle 10, 7.3 ns: at 8 ns; the second at 58 ns.
  EXPECT_EQ(bench.driver.sent_at(), (std::vector<Cycle>{10, 11}));
  const Cycle arrival = 11 * bench.core.period_fs() / bench.memory.period_fs() + 1;
  EXPECT_EQ(bench.device.port.counters().full_clocks, 58 - arrival);
}

TEST_F(DramPortAt, FixedLatencyIsAddedToEveryResponse) {
  std::vector<Cycle> answered;
  for (const Cycle fixed : {Cycle{0}, Cycle{1365}}) {
    {
      DramPort::Config config;
      config.fixed_latency = fixed;
      Bench bench(config, 1365.0);
      const auto id = bench.driver.at(10, 64);
      EXPECT_TRUE(run_until_quiet(bench.core, 100'000));
      answered.push_back(bench.driver.answered(id));
    }
    fresh_context();
  }
  EXPECT_EQ(answered[1] - answered[0], 1365u);
}

TEST_F(DramPortAt, MalformedRequestsAreRefusedAndGoNoFurther) {
  DramPort::Config config;
  config.longest = 64;
  config.bytes = 4096;
  Bench bench(config);
  const auto good = bench.driver.at(1, 4096 - 32);
  const auto beyond = bench.driver.at(2, 4096);
  const auto longer = bench.driver.at(3, 0, false, 128);
  EXPECT_TRUE(run_until_quiet(bench.core, 100'000));
  std::map<std::uint32_t, bool> ok;
  for (const auto& answer : bench.driver.answers()) ok[answer.completion.context] = answer.completion.ok();
  EXPECT_EQ(ok, (std::map<std::uint32_t, bool>{{good, true}, {beyond, false}, {longer, false}}));
  EXPECT_EQ(bench.device.taken, 1u);
  EXPECT_EQ(bench.device.port.counters().refused, 2u);
}

// A null data pointer is refused, and a read that is answered with OK has been answered: with zeros.
TEST_F(DramPortAt, AReadWithOkFillsTheBuffer) {
  for (const bool null : {false, true}) {
    fresh_context();
    modules::ClockDomain memory("memory", 1000.0);
    Device device("device", memory, {}, 1, 20, 0);
    modules::RawAtInitiator initiator("initiator");
    initiator.socket.bind(device.port.socket);
    modules::AtPayload& payload = initiator.payload(0x40);
    payload.acquire();
    payload.data.fill(0xab);
    if (null) payload.set_data_ptr(nullptr);
    modules::elaborate();
    initiator.send(payload);
    EXPECT_TRUE(run_until_quiet(memory, 1000));
    EXPECT_EQ(payload.get_response_status(), null ? ::tlm::TLM_GENERIC_ERROR_RESPONSE : ::tlm::TLM_OK_RESPONSE);
    EXPECT_EQ(payload.data[31], null ? 0xab : 0);
    payload.data.fill(0xab);
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    initiator.socket->b_transport(payload, delay);
    EXPECT_EQ(payload.data[31], null ? 0xab : 0);
  }
}

}  // namespace
}  // namespace grtx::sim
