// SPDX-License-Identifier: Apache-2.0
// TlmToLink: a foreign TLM-2.0 initiator drives an L1 (and what is behind it) or an L2 slice.
#include <array>
#include <tuple>

#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/tlm/tlm_to_link.h"
#include "modules/cache/hierarchy_bench.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

constexpr DramTiming kT{};
constexpr std::uint64_t kNs = 1'000'000;  // in fs

/// A loosely timed platform: threads that call b_transport.
class LtInitiator final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = LtInitiator;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  struct Call {
    std::uint64_t start_fs;
    std::uint64_t address;
    unsigned bytes;
    bool write;
    std::uint64_t delay_fs = 0;  ///< annotated: the initiator is ahead of the kernel
  };
  LtInitiator(const sc_core::sc_module_name& name, std::vector<Call> calls)
      : sc_module(name), socket("socket"), calls_(std::move(calls)) {
    SC_THREAD(run);
  }
  tlm_utils::simple_initiator_socket<LtInitiator, 32> socket;
  std::vector<std::uint64_t> ended_fs;
  std::vector<::tlm::tlm_response_status> status;

 private:
  void run() {
    std::vector<unsigned char> data(4096);
    for (const Call& call : calls_) {
      const sc_core::sc_time start = sc_core::sc_time::from_value(call.start_fs);
      if (start > sc_core::sc_time_stamp()) wait(start - sc_core::sc_time_stamp());
      ::tlm::tlm_generic_payload payload;  // no memory manager: blocking calls need none
      payload.set_command(call.write ? ::tlm::TLM_WRITE_COMMAND : ::tlm::TLM_READ_COMMAND);
      payload.set_address(call.address);
      payload.set_data_ptr(data.data());
      payload.set_data_length(call.bytes);
      payload.set_streaming_width(call.bytes);
      payload.set_response_status(::tlm::TLM_INCOMPLETE_RESPONSE);
      sc_core::sc_time delay = sc_core::sc_time::from_value(call.delay_fs);
      socket->b_transport(payload, delay);
      ended_fs.push_back((sc_core::sc_time_stamp() + delay).value());
      status.push_back(payload.get_response_status());
    }
  }
  std::vector<Call> calls_;
};

/// Starts non-blocking transactions at any time and notes when BEGIN_RESP came.
class NbInitiator final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = NbInitiator;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  explicit NbInitiator(const sc_core::sc_module_name& name) : sc_module(name), socket("socket") {
    socket.register_nb_transport_bw(this, &NbInitiator::nb_transport_bw);
    SC_METHOD(act);
    sensitive << wake_;
    dont_initialize();
  }
  tlm_utils::simple_initiator_socket<NbInitiator, 32> socket;

  void at(std::uint64_t fs, std::uint64_t address, unsigned bytes = 32, bool write = false) {
    AtPayload& p = pool_.acquire();
    p.set_command(write ? ::tlm::TLM_WRITE_COMMAND : ::tlm::TLM_READ_COMMAND);
    p.set_address(address);
    p.set_data_ptr(p.data.data());
    p.set_data_length(bytes);
    p.set_streaming_width(bytes);
    p.context = static_cast<std::uint32_t>(answered_fs.size());
    answered_fs.push_back(0);
    script_.emplace(fs, &p);
    wake_.notify(sc_core::sc_time::from_value(script_.begin()->first) - sc_core::sc_time_stamp());
  }
  std::vector<std::uint64_t> answered_fs;  ///< of BEGIN_RESP; 0: not yet
  bool complete() const { return pool_.live() == 0 && std::count(answered_fs.begin(), answered_fs.end(), 0u) == 0; }

 private:
  void act() {
    const std::uint64_t now = sc_core::sc_time_stamp().value();
    if (requesting_ == nullptr && !script_.empty() && script_.begin()->first <= now) {
      AtPayload& payload = *script_.begin()->second;
      script_.erase(script_.begin());
      requesting_ = &payload;
      ::tlm::tlm_phase phase = tlm::BEGIN_REQ;
      sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
      if (socket->nb_transport_fw(payload, phase, delay) == ::tlm::TLM_COMPLETED) {
        answered_fs[payload.context] = now;
        requesting_ = nullptr;
        payload.release();
      }
    }
    if (requesting_ == nullptr && !script_.empty()) {
      const std::uint64_t next = std::max(now + 1, script_.begin()->first);
      wake_.notify(sc_core::sc_time::from_value(next - now));
    }
  }
  ::tlm::tlm_sync_enum nb_transport_bw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time& delay) {
    if (&payload == requesting_) {
      requesting_ = nullptr;
      wake_.notify(delay);
    }
    if (phase != tlm::BEGIN_RESP) return ::tlm::TLM_ACCEPTED;
    answered_fs[static_cast<AtPayload&>(payload).context] = (sc_core::sc_time_stamp() + delay).value();
    payload.release();
    return ::tlm::TLM_COMPLETED;
  }

  AtPayloadPool pool_;
  sc_core::sc_event wake_;
  std::multimap<std::uint64_t, AtPayload*> script_;
  ::tlm::tlm_generic_payload* requesting_ = nullptr;
};

class TlmBridge : public SystemCTest {
 protected:
  /// The hierarchy with a bridge at client 0 of SM 0.
  struct Bench {
    explicit Bench(HierarchyBench::Config config = {}, TlmToLink::Config bridge_config = {})
        : below([&] {
            config.clients = false;
            return config;
          }()),
          bridge("bridge", bridge_config, below.core) {
      bridge.request.bind(below.client_links[0]->request);
      bridge.response.bind(below.client_links[0]->response);
    }
    std::uint64_t core() const { return below.core.period_fs(); }
    /// The cycle in which the L1 sees the sector of a call at time t: first edge after t, and the link.
    Cycle visible(std::uint64_t fs) const { return fs / core() + 1 + 1; }
    HierarchyBench below;
    TlmToLink bridge;
  };
  // From the L1 on, as in hierarchy_test.cpp.
  static Cycle l1_hit(Cycle visible) { return visible + 20; }
  static Cycle l2_hit(const HierarchyBench::Config& c, Cycle visible) {
    return visible + c.l1.tag_latency + 1 + c.crossbar.latency + c.l2.latency + 1 + c.crossbar.latency + 1;
  }
  static Cycle dram_access(const Bench& bench, const HierarchyBench::Config& c, Cycle visible, Cycle clocks) {
    const std::uint64_t core = bench.core();
    const std::uint64_t memory = bench.below.memory.period_fs();
    const Cycle sent = visible + c.l1.tag_latency + 1 + c.crossbar.latency + c.l2.latency;
    const Cycle filled = (sent * core / memory + 1 + clocks) * memory / core + 1;
    return filled + 1 + c.crossbar.latency + 1;
  }
};

// Foreign initiator -> bridge -> L1 -> crossbar -> L2 -> DRAM and back, nothing else under way.
TEST_F(TlmBridge, UnloadedLatencyOfAForeignInitiatorIsTheFormula) {
  const HierarchyBench::Config config;
  constexpr Cycle kRowMiss = kT.rcd + kT.cl + kT.ccd + 256;
  constexpr Cycle kRowHit = kT.cl + kT.ccd + 256;
  // Times that are on no edge of any clock.
  const std::uint64_t times[] = {73 * kNs + 1, 2000 * kNs + 333'333, 4000 * kNs + 7};
  {
    Bench bench(config);
    NbInitiator initiator("initiator");
    AtProtocolChecker checker("checker", {.project_rules = false});
    initiator.socket.bind(checker.target);
    checker.initiator.bind(bench.bridge.socket);
    initiator.at(times[0], 0x5000);
    initiator.at(times[1], 0x5000);
    initiator.at(times[2], 0x5020);
    EXPECT_TRUE(run_until_quiet(bench.below.core, 20000));
    const auto& answered = initiator.answered_fs;
    EXPECT_EQ(answered[0], dram_access(bench, config, bench.visible(times[0]), kRowMiss) * bench.core());
    EXPECT_EQ(answered[1], l1_hit(bench.visible(times[1])) * bench.core());
    EXPECT_EQ(answered[2], dram_access(bench, config, bench.visible(times[2]), kRowHit) * bench.core());
    EXPECT_EQ(checker.violations(), 0u) << checker.messages().front();
    EXPECT_TRUE(initiator.complete());
    EXPECT_TRUE(bench.bridge.idle());
  }
  fresh_context();
  {
    Bench bench(config);
    LtInitiator initiator("initiator", {{times[0], 0x5000, 32, false},
                                        {times[1], 0x5000, 4, false},
                                        {times[2] - 50, 0x5020, 32, false, 50}});  // annotated ahead of the kernel
    initiator.socket.bind(bench.bridge.socket);
    run(bench.below.core, 1);  // threads begin
    EXPECT_TRUE(run_until_quiet(bench.below.core, 20000));
    ASSERT_EQ(initiator.ended_fs.size(), 3u);
    EXPECT_EQ(initiator.ended_fs[0], dram_access(bench, config, bench.visible(times[0]), kRowMiss) * bench.core());
    EXPECT_EQ(initiator.ended_fs[1], l1_hit(bench.visible(times[1])) * bench.core());
    EXPECT_EQ(initiator.ended_fs[2], dram_access(bench, config, bench.visible(times[2]), kRowHit) * bench.core());
  }
}

TEST_F(TlmBridge, AHitAfterARestartTakesItsLatency) {
  const HierarchyBench::Config config;
  Bench bench(config);
  NbInitiator initiator("initiator");
  initiator.socket.bind(bench.bridge.socket);
  initiator.at(1'000'000 * kNs, 0x5000);
  EXPECT_TRUE(run_until_quiet(bench.below.core, 2'000'000));
  bench.below.core.restart(Caches::warm);
  bench.below.memory.restart(Caches::warm);
  EXPECT_EQ(bench.bridge.transactions(), 0u);
  EXPECT_EQ(bench.below.client_links[0]->request.pushed(), 0u);
  const std::uint64_t begin = sc_core::sc_time_stamp().value(), call = 100 * kNs + 1;
  initiator.at(begin + call, 0x5000);
  EXPECT_TRUE(run_until_quiet(bench.below.core, 20000));
  EXPECT_EQ(initiator.answered_fs[1] - begin, l1_hit(bench.visible(call)) * bench.core());
  EXPECT_EQ(bench.bridge.transactions(), 1u);
}

/// The report handler's actions for errors, as a platform may have them: not to throw.
struct ErrorsDoNotThrow {
  ErrorsDoNotThrow() { sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_DO_NOTHING); }
  ~ErrorsDoNotThrow() { sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_DEFAULT_ERROR_ACTIONS); }
  ErrorsDoNotThrow(const ErrorsDoNotThrow&) = delete;
  ErrorsDoNotThrow& operator=(const ErrorsDoNotThrow&) = delete;
};

TEST_F(TlmBridge, AnEndRespWithoutABeginRespChangesNothingWhereReportsDoNotThrow) {
  Bench bench;
  RawAtInitiator initiator("initiator");
  initiator.socket.bind(bench.bridge.socket);
  AtPayload& payload = initiator.payload(0x5000);
  const ErrorsDoNotThrow quiet;
  run(bench.below.core, 1);
  initiator.send(payload, tlm::END_RESP);
  EXPECT_EQ(payload.get_response_status(), ::tlm::TLM_GENERIC_ERROR_RESPONSE);
  payload.set_response_status(::tlm::TLM_INCOMPLETE_RESPONSE);
  AtPayload& second = initiator.payload(0x6000);
  initiator.send(payload);
  initiator.send(second);  // before END_REQ of the first
  EXPECT_EQ(second.get_response_status(), ::tlm::TLM_GENERIC_ERROR_RESPONSE);
  EXPECT_TRUE(run_until_quiet(bench.below.core, 20000));
  EXPECT_EQ(payload.get_response_status(), ::tlm::TLM_OK_RESPONSE);
  EXPECT_TRUE(bench.bridge.idle());
}

TEST_F(TlmBridge, AnAnswerThatNobodyWaitsForIsBlamedOnWhatIsBehind) {
  ClockDomain core("core", 1365.0);
  PortLinks links("port");
  TlmToLink bridge("bridge", {}, core);
  bridge.request.bind(links.request);
  bridge.response.bind(links.response);
  RawAtInitiator initiator("initiator");
  initiator.socket.bind(bridge.socket);
  TickProcess liar("liar", core, [&](Cycle now) {
    if (now == 3) links.response.push(now, {.tag = 9999});
  });
  core.request(3);
  try {
    run(core, 10);
    ADD_FAILURE() << "the answer was taken";
  } catch (const sc_core::sc_report& report) {
    EXPECT_STREQ(report.get_msg(), "bridge: what is behind has answered request 9999, which is not under way");
  }
}

TEST_F(TlmBridge, AnL2SliceAloneIsATargetToo) {
  ClockDomain core("core", 1365.0);
  ClockDomain memory("memory", 3500.0);
  L2Slice::Config config;
  config.interleave.slices = 1;
  Dram::Config dram_config;
  dram_config.interleave.slices = 1;
  L2Slice l2("l2", config, core);
  Dram dram("dram", dram_config, memory);
  PortLinks links("port");
  TlmToLink bridge("bridge", {}, core);
  NbInitiator initiator("initiator");
  l2.request.bind(links.request);
  l2.response.bind(links.response);
  l2.dram.socket.bind(dram.sockets[0]);
  bridge.request.bind(links.request);
  bridge.response.bind(links.response);
  initiator.socket.bind(bridge.socket);
  initiator.at(100 * kNs, 0x40, 32, true);
  initiator.at(3000 * kNs, 0x40);
  EXPECT_TRUE(run_until_quiet(core, 20000));
  // Edge, link, L2, link.
  for (const auto& [i, time] : {std::pair(0U, 100 * kNs), std::pair(1U, 3000 * kNs)}) {
    EXPECT_EQ(initiator.answered_fs[i], (time / core.period_fs() + 1 + 1 + config.latency + 1) * core.period_fs()) << i;
  }
  EXPECT_EQ(l2.counters().requests_in, 2u);
}

TEST_F(TlmBridge, ATransactionIsCutIntoTheSectorsThatItTouches) {
  struct Case {
    std::uint64_t address;
    unsigned bytes;
    unsigned sectors;
  };
  const Case cases[] = {{0x1000, 32, 1},  {0x2004, 4, 1},   {0x3000, 64, 2}, {0x401E, 4, 2},
                        {0x5000, 128, 4}, {0x6010, 128, 5}, {0x701F, 2, 2},  {0x8000, 1, 1}};
  for (const bool blocking : {false, true}) {
    fresh_context();
    Bench bench;
    NbInitiator non_blocking("nb");
    std::vector<LtInitiator::Call> calls;
    std::uint64_t expected = 0;
    for (std::size_t i = 0; i < std::size(cases); ++i) {
      if (!blocking) non_blocking.at((100 + 2000 * i) * kNs, cases[i].address, cases[i].bytes);
      calls.push_back({(100 + 2000 * i) * kNs, cases[i].address, cases[i].bytes, false});
      expected += cases[i].sectors;
    }
    LtInitiator lt("lt", blocking ? calls : std::vector<LtInitiator::Call>{});
    PortLinks unused_links("unused");
    TlmToLink unused("unused", {}, bench.below.core);  // an initiator that is not bound is an error
    unused.request.bind(unused_links.request);
    unused.response.bind(unused_links.response);
    lt.socket.bind((blocking ? bench.bridge : unused).socket);
    non_blocking.socket.bind((blocking ? unused : bench.bridge).socket);
    run(bench.below.core, 1);  // threads begin
    EXPECT_TRUE(run_until_quiet(bench.below.core, 100000));
    EXPECT_EQ(bench.bridge.sectors(), expected);
    EXPECT_EQ(bench.bridge.transactions(), std::size(cases));
    EXPECT_EQ(bench.below.l1[0]->counters().accesses(), expected);
    EXPECT_TRUE(bench.bridge.idle());
  }
}

TEST_F(TlmBridge, ManyAreUnderWayAndRequestsBeyondTheLimitWaitInTheirRequestPhase) {
  for (const unsigned limit : {1U, 2U, 8U}) {
    fresh_context();
    Bench bench({}, {.outstanding = limit});
    NbInitiator initiator("initiator");
    AtProtocolChecker checker("checker", {.project_rules = false});
    initiator.socket.bind(checker.target);
    checker.initiator.bind(bench.bridge.socket);
    for (unsigned i = 0; i < 200; ++i) initiator.at(100 * kNs, i * 4096, 64, i % 5 == 0);
    EXPECT_TRUE(run_until_quiet(bench.below.core, 1'000'000));
    EXPECT_TRUE(initiator.complete());
    EXPECT_EQ(checker.violations(), 0u) << checker.messages().front();
    const std::uint64_t last = *std::max_element(initiator.answered_fs.begin(), initiator.answered_fs.end());
    // A transaction is inside for at least the L2 latency there and back, 185 cycles, and `limit` at a time.
    EXPECT_GE(last / bench.core(), 200 / limit * 185);
  }
}

TEST_F(TlmBridge, MalformedTransactionsGetTheStandardsErrorStatus) {
  Bench bench;
  LtInitiator initiator("initiator", {{100 * kNs, 0, 0, false}, {200 * kNs, std::uint64_t{1} << 41, 32, false}});
  initiator.socket.bind(bench.bridge.socket);
  run(bench.below.core, 1);  // threads begin
  EXPECT_TRUE(run_until_quiet(bench.below.core, 20000));
  EXPECT_EQ(initiator.status, (std::vector<::tlm::tlm_response_status>{::tlm::TLM_BURST_ERROR_RESPONSE,
                                                                       ::tlm::TLM_ADDRESS_ERROR_RESPONSE}));
  EXPECT_EQ(bench.bridge.refused(), 2u);
  EXPECT_EQ(bench.bridge.sectors(), 0u);
}

// Caches number sectors in 32 bits; the bridge let 40 bits of address pass, and an assert ended the process.
TEST_F(TlmBridge, AnAddressOf2To37OrOneThatWrapsIsRefused) {
  Bench bench;
  constexpr std::uint64_t kWraps = ~std::uint64_t{0} - 15;
  LtInitiator initiator("initiator", {{100 * kNs, kAddressable - 32, 32, false},
                                      {2000 * kNs, kAddressable - 16, 32, false},
                                      {3000 * kNs, std::uint64_t{1} << 37, 32, true},
                                      {4000 * kNs, kWraps, 32, false},
                                      {5000 * kNs, kWraps, 16, true}});
  initiator.socket.bind(bench.bridge.socket);
  run(bench.below.core, 1);  // threads begin
  EXPECT_TRUE(run_until_quiet(bench.below.core, 20000));
  std::vector<::tlm::tlm_response_status> expected(5, ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
  expected[0] = ::tlm::TLM_OK_RESPONSE;
  EXPECT_EQ(initiator.status, expected);
  EXPECT_EQ(bench.bridge.sectors(), 1u);
  ::tlm::tlm_generic_payload payload;
  std::array<unsigned char, 32> data{};
  payload.set_read();
  payload.set_data_ptr(data.data());
  payload.set_data_length(32);
  payload.set_address(kWraps);
  EXPECT_EQ(initiator.socket->transport_dbg(payload), 0u);
}

}  // namespace
}  // namespace grtx::modules
