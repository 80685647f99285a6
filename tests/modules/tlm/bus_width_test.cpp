// SPDX-License-Identifier: Apache-2.0
// BusWidth: through it everything is as without it.
#include "grtx/modules/tlm/bus_width.h"

#include <gtest/gtest.h>

#include <optional>

#include "grtx/modules/tlm/functional_memory.h"
#include "modules/systemc_fixture.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

class BusWidths : public SystemCTest {
 protected:
  /// Cycles and statuses of random requests, directly or by way of a bus of 64 bits.
  std::vector<std::pair<Cycle, std::uint32_t>> answers(AtBehaviour behaviour, bool through) {
    fresh_context();
    ClockDomain core("core", 1365.0);
    AtDriver driver("driver", core);
    MockAtTarget target("target", core, behaviour);
    std::optional<BusWidth<32, 64>> wide;
    std::optional<BusWidth<64, 32>> narrow;
    if (through) {
      wide.emplace("wide");
      narrow.emplace("narrow");
      driver.initiator.socket.bind(wide->from);
      wide->to.bind(narrow->from);
      narrow->to.bind(target.socket);
    } else {
      driver.initiator.socket.bind(target.socket);
    }
    Random random(7);
    for (Cycle cycle = 1; cycle < 400; cycle += 1 + random.below(9)) {
      driver.at(cycle, random.below(1000) * 32, random.chance(40));
    }
    elaborate();
    EXPECT_TRUE(run_until_quiet(core, 100000));
    EXPECT_TRUE(driver.complete());
    std::vector<std::pair<Cycle, std::uint32_t>> all;
    for (const auto& answer : driver.answers()) all.emplace_back(answer.cycle, answer.completion.context);
    return all;
  }
};

TEST_F(BusWidths, ChangeNoTimeAndNoOrder) {
  for (const AtBehaviour behaviour :
       {AtBehaviour::plain, AtBehaviour::withheld, AtBehaviour::no_end_request, AtBehaviour::updated,
        AtBehaviour::updated_response, AtBehaviour::completed, AtBehaviour::annotated, AtBehaviour::out_of_order}) {
    EXPECT_EQ(answers(behaviour, true), answers(behaviour, false)) << static_cast<int>(behaviour);
  }
}

/// 64 bits wide, with data and direct access to them.
class WideMemory final : public sc_core::sc_module {
 public:
  explicit WideMemory(const sc_core::sc_module_name& name) : sc_module(name), socket("socket") {
    socket.register_b_transport(this, &WideMemory::b_transport);
    socket.register_transport_dbg(this, &WideMemory::transport_dbg);
    socket.register_get_direct_mem_ptr(this, &WideMemory::get_direct_mem_ptr);
  }
  tlm_utils::simple_target_socket<WideMemory, 64> socket;

 private:
  void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    memory_.access(payload);
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    delay += sc_core::sc_time(50, sc_core::SC_NS);
  }
  unsigned transport_dbg(::tlm::tlm_generic_payload& payload) { return memory_.access(payload); }
  bool get_direct_mem_ptr(::tlm::tlm_generic_payload&, ::tlm::tlm_dmi& dmi) {
    dmi.set_start_address(0x40);
    return true;
  }
  FunctionalMemory memory_;
};

struct Caller final : sc_core::sc_module {
  using SC_CURRENT_USER_MODULE = Caller;
  explicit Caller(const sc_core::sc_module_name& name) : sc_module(name), socket("socket") {
    socket.register_invalidate_direct_mem_ptr(this, &Caller::invalidated);
    SC_THREAD(run);
  }
  void run() {
    unsigned char byte = 0xab, read = 0;
    ::tlm::tlm_generic_payload payload;
    payload.set_command(::tlm::TLM_WRITE_COMMAND);
    payload.set_address(0x123);
    payload.set_data_ptr(&byte);
    payload.set_data_length(1);
    payload.set_streaming_width(1);
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    socket->b_transport(payload, delay);
    EXPECT_EQ(delay, sc_core::sc_time(50, sc_core::SC_NS));
    EXPECT_TRUE(payload.is_response_ok());
    payload.set_command(::tlm::TLM_READ_COMMAND);
    payload.set_data_ptr(&read);
    EXPECT_EQ(socket->transport_dbg(payload), 1u);
    EXPECT_EQ(read, 0xab);
    ::tlm::tlm_dmi dmi;
    EXPECT_TRUE(socket->get_direct_mem_ptr(payload, dmi));
    EXPECT_EQ(dmi.get_start_address(), 0x40u);
    done = true;
  }
  void invalidated(sc_dt::uint64 from, sc_dt::uint64 to) { gone = {from, to}; }
  tlm_utils::simple_initiator_socket<Caller, 32> socket;
  std::pair<std::uint64_t, std::uint64_t> gone;
  bool done = false;
};

TEST_F(BusWidths, PassOnBlockingCallsDataAndDirectAccess) {
  Caller caller("caller");
  BusWidth<32, 64> wide("wide");
  WideMemory memory("memory");
  caller.socket.bind(wide.from);
  wide.to.bind(memory.socket);
  elaborate();
  sc_core::sc_start(sc_core::sc_time(1, sc_core::SC_US));
  EXPECT_TRUE(caller.done);
  memory.socket->invalidate_direct_mem_ptr(1, 2);
  EXPECT_EQ(caller.gone, std::pair(std::uint64_t{1}, std::uint64_t{2}));
}

}  // namespace
}  // namespace grtx::modules
