// SPDX-License-Identifier: Apache-2.0
// A thread that is killed or reset inside a blocking call leaves nothing behind: its payload and its stack are gone,
// and who comes after it is served.
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/tlm/at_monitor.h"
#include "grtx/modules/tlm/functional_memory.h"
#include "grtx/modules/tlm/tlm_to_link.h"
#include "modules/memory_mocks.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

/// Answers each request 100 cycles later.
class SlowMemory final {
 public:
  SlowMemory(ClockDomain& clock, PortLinks& links)
      : process_("memory", clock, [this, &links, &clock](Cycle now) {
          while (const MemoryRequest* request = links.request.front(now)) {
            waiting_.emplace_back(now + 100, response_to(*request));
            links.request.pop(now);
          }
          while (!waiting_.empty() && waiting_.front().first <= now && links.response.can_push(now)) {
            links.response.push(now, waiting_.front().second);
            waiting_.pop_front();
          }
          if (!waiting_.empty()) clock.request(std::max(now + 1, waiting_.front().first));
        }) {
    process_.watch(links.request);
  }

 private:
  std::deque<std::pair<Cycle, MemoryResponse>> waiting_;
  TickProcess process_;
};

/// Writes `value` to 0x40 and the 100 bytes behind it.
struct Writer final : sc_core::sc_module {
  using SC_CURRENT_USER_MODULE = Writer;
  Writer(const sc_core::sc_module_name& name, unsigned char value, sc_core::sc_time begin)
      : sc_module(name), value_(value), begin_(begin) {
    SC_THREAD(run);
  }
  void run() {
    process = sc_core::sc_get_current_process_handle();
    ++runs;
    if (sc_core::sc_time_stamp() < begin_) wait(begin_ - sc_core::sc_time_stamp());
    std::array<unsigned char, 100> data;
    data.fill(value_);
    ::tlm::tlm_generic_payload payload;
    payload.set_write();
    payload.set_address(0x40);
    payload.set_data_ptr(data.data());
    payload.set_data_length(100);
    payload.set_streaming_width(100);
    sc_core::sc_time delay(10, sc_core::SC_NS);
    socket->b_transport(payload, delay);
    ended += payload.is_response_ok() ? 1 : 0;
  }
  tlm_utils::simple_initiator_socket<Writer, 32> socket{"socket"};
  sc_core::sc_process_handle process;
  unsigned runs = 0, ended = 0;

 private:
  unsigned char value_;
  sc_core::sc_time begin_;
};

/// Kills or resets the writer at a time.
struct Killer final : sc_core::sc_module {
  using SC_CURRENT_USER_MODULE = Killer;
  Killer(const sc_core::sc_module_name& name, Writer& writer, sc_core::sc_time at, bool resets)
      : sc_module(name), writer_(writer), at_(at), resets_(resets) {
    SC_THREAD(run);
  }
  void run() {
    wait(at_);
    resets_ ? writer_.process.reset() : writer_.process.kill();
  }

 private:
  Writer& writer_;
  sc_core::sc_time at_;
  bool resets_;
};

class KilledThread : public SystemCTest {};

TEST_F(KilledThread, InsideTheBridgeWritesNothingAndLeavesItIdle) {
  // Waits for its annotated delay; has sent some sectors; waits for the answers; has ended.
  for (const double at_ns : {5.0, 12.5, 60.0, 1000.0}) {
    for (const bool resets : {false, true}) {
      fresh_context();
      ClockDomain core("core", 1365.0);
      PortLinks links("port");
      SlowMemory memory(core, links);
      FunctionalMemory contents;
      unsigned accesses = 0;
      TlmToLink::Config config{.outstanding = 2};
      config.data = [&](::tlm::tlm_generic_payload& payload) {
        ++accesses;
        return contents.access(payload);
      };
      TlmToLink bridge("bridge", config, core);
      bridge.request.bind(links.request);
      bridge.response.bind(links.response);
      AtMonitor monitor("monitor");
      monitor.initiator.bind(bridge.socket);
      Writer killed("killed", 0x11, sc_core::SC_ZERO_TIME);
      killed.socket.bind(monitor.target);
      Killer killer("killer", killed, sc_core::sc_time(at_ns, sc_core::SC_NS), resets);
      run(core, 1);  // threads begin
      EXPECT_TRUE(run_until_quiet(core, 20000));
      const bool was_inside = at_ns < 500;
      const unsigned calls = resets && was_inside ? 2u : 1u;  // what has ended is not begun again
      const unsigned answered = was_inside ? calls - 1 : calls;
      EXPECT_EQ(killed.runs, calls) << at_ns;
      EXPECT_EQ(killed.ended, answered) << at_ns;
      EXPECT_EQ(accesses, answered) << "what was killed writes nothing: " << at_ns;
      EXPECT_TRUE(bridge.idle());
      EXPECT_TRUE(monitor.idle());
      EXPECT_EQ(monitor.outstanding(), 0u);
      EXPECT_EQ(monitor.traffic().refused, calls - answered) << at_ns;
      EXPECT_FALSE(sc_core::sc_pending_activity());
    }
  }
}

TEST_F(KilledThread, GivesItsPlaceInTheBridgeToTheNext) {
  ClockDomain core("core", 1365.0);
  PortLinks links("port");
  SlowMemory memory(core, links);
  TlmToLink bridge("bridge", {.outstanding = 1}, core);
  bridge.request.bind(links.request);
  bridge.response.bind(links.response);
  Writer killed("killed", 0x11, sc_core::SC_ZERO_TIME);
  killed.socket.bind(bridge.socket);
  Killer killer("killer", killed, sc_core::sc_time(20, sc_core::SC_NS), true);
  run(core, 1);
  EXPECT_TRUE(run_until_quiet(core, 20000));
  // The second call waits for the first's place, and is answered by its own four sectors.
  EXPECT_EQ(killed.ended, 1u);
  EXPECT_EQ(bridge.transactions(), 2u);
  EXPECT_EQ(bridge.sectors(), 8u);
  EXPECT_TRUE(bridge.idle());
}

}  // namespace
}  // namespace grtx::modules
