// SPDX-License-Identifier: Apache-2.0
// Monitor and protocol checker, which change nothing, pass direct memory access on in both directions.
#include <gtest/gtest.h>

#include <optional>

#include "grtx/modules/tlm/at_monitor.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

/// Grants direct access, says so in its responses, and takes it back.
struct OpenMemory final : sc_core::sc_module {
  explicit OpenMemory(const sc_core::sc_module_name& name) : sc_module(name) {
    socket.register_b_transport(this, &OpenMemory::b_transport);
    socket.register_transport_dbg(this, &OpenMemory::transport_dbg);
    socket.register_get_direct_mem_ptr(this, &OpenMemory::get_direct_mem_ptr);
  }
  void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time&) {
    payload.set_dmi_allowed(true);
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
  }
  unsigned transport_dbg(::tlm::tlm_generic_payload&) { return 17; }
  bool get_direct_mem_ptr(::tlm::tlm_generic_payload& payload, ::tlm::tlm_dmi& dmi) {
    dmi.set_dmi_ptr(&byte);
    dmi.set_start_address(payload.get_address());
    dmi.allow_read_write();
    return true;
  }
  tlm_utils::simple_target_socket<OpenMemory, 32> socket{"socket"};
  unsigned char byte = 0;
};

struct DirectUser final : sc_core::sc_module {
  using SC_CURRENT_USER_MODULE = DirectUser;
  explicit DirectUser(const sc_core::sc_module_name& name) : sc_module(name) {
    socket.register_invalidate_direct_mem_ptr(this, &DirectUser::invalidated);
    SC_THREAD(run);
  }
  void run() {
    std::array<unsigned char, 32> data{};
    ::tlm::tlm_generic_payload payload;
    payload.set_read();
    payload.set_address(0x40);
    payload.set_data_ptr(data.data());
    payload.set_data_length(32);
    payload.set_streaming_width(32);
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    socket->b_transport(payload, delay);
    hinted = payload.is_dmi_allowed();
    debugged = socket->transport_dbg(payload);
    granted = socket->get_direct_mem_ptr(payload, dmi);
  }
  void invalidated(sc_dt::uint64 from, sc_dt::uint64 to) { gone = {from, to}; }
  tlm_utils::simple_initiator_socket<DirectUser, 32> socket{"socket"};
  ::tlm::tlm_dmi dmi;
  std::pair<std::uint64_t, std::uint64_t> gone;
  unsigned debugged = 0;
  bool hinted = false, granted = false;
};

class InLine : public SystemCTest {};

TEST_F(InLine, MonitorAndCheckerPassOnDirectMemoryAccess) {
  DirectUser user("user");
  AtProtocolChecker checker("checker", {});
  AtMonitor monitor("monitor");
  OpenMemory memory("memory");
  user.socket.bind(checker.target);
  checker.initiator.bind(monitor.target);
  monitor.initiator.bind(memory.socket);
  elaborate();
  EXPECT_TRUE(user.hinted);
  EXPECT_EQ(user.debugged, 17u);
  ASSERT_TRUE(user.granted);
  EXPECT_EQ(user.dmi.get_dmi_ptr(), &memory.byte);
  EXPECT_EQ(user.dmi.get_start_address(), 0x40u);
  memory.socket->invalidate_direct_mem_ptr(1, 2);
  EXPECT_EQ(user.gone, std::pair(std::uint64_t{1}, std::uint64_t{2}));
  EXPECT_EQ(checker.violations(), 0u);
  EXPECT_EQ(monitor.traffic().reads, 1u) << "debug and direct accesses are not counted";
}

}  // namespace
}  // namespace grtx::modules
