// SPDX-License-Identifier: Apache-2.0
// Rules that all targets share: a payload without data pointer is refused, and what is read with an OK has been written
// into the initiator's buffer, also where there is no data.
#include "grtx/modules/tlm/target_rules.h"

#include "grtx/modules/dram/dram.h"
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/tlm/tlm_to_link.h"
#include "modules/memory_mocks.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

class TargetRules : public SystemCTest {
 protected:
  struct Memory {
    Memory() : clock("clock", 3500.0), dram("dram", config(), clock), initiator("initiator") {
      initiator.socket.bind(dram.sockets[0]);
    }
    static Dram::Config config() {
      Dram::Config config;
      config.interleave.slices = 1;
      return config;
    }
    ClockDomain clock;
    Dram dram;
    RawAtInitiator initiator;
  };
  static ::tlm::tlm_response_status b_transport(RawAtInitiator& initiator, ::tlm::tlm_generic_payload& payload) {
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    initiator.socket->b_transport(payload, delay);
    return payload.get_response_status();
  }
};

TEST_F(TargetRules, AReadThatADramAnswersWithOkFillsTheBuffer) {
  for (const bool blocking : {true, false}) {
    fresh_context();
    Memory memory;
    AtPayload& read = memory.initiator.payload(0x40);
    read.acquire();
    read.data.fill(0xab);
    TickProcess starter("starter", memory.clock, [&](Cycle now) {
      if (now != 5) return;
      if (blocking) {
        b_transport(memory.initiator, read);
      } else {
        memory.initiator.send(read);
      }
    });
    memory.clock.request(5);
    run(memory.clock, 2000);
    EXPECT_EQ(read.get_response_status(), ::tlm::TLM_OK_RESPONSE);
    for (unsigned i = 0; i < 32; ++i) ASSERT_EQ(read.data[i], 0) << i;
    EXPECT_EQ(read.data[32], 0xab) << "not asked for";
    EXPECT_EQ(memory.initiator.socket->transport_dbg(read), 0u) << "it holds no data";
  }
}

TEST_F(TargetRules, ARefusedReadAndAWriteLeaveTheBuffer) {
  Memory memory;
  elaborate();
  AtPayload& read = memory.initiator.payload(0x41);  // not aligned
  read.data.fill(0xab);
  EXPECT_EQ(b_transport(memory.initiator, read), ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
  EXPECT_EQ(read.data[0], 0xab);
  AtPayload& write = memory.initiator.payload(0x40);
  write.set_write();
  write.data.fill(0xab);
  EXPECT_EQ(b_transport(memory.initiator, write), ::tlm::TLM_OK_RESPONSE);
  EXPECT_EQ(write.data[0], 0xab);
}

TEST_F(TargetRules, ANullDataPointerIsRefusedByTheDram) {
  for (const bool blocking : {true, false}) {
    fresh_context();
    Memory memory;
    AtPayload& payload = memory.initiator.payload(0x40);
    payload.acquire();
    payload.set_data_ptr(nullptr);
    TickProcess starter("starter", memory.clock, [&](Cycle now) {
      if (now != 5) return;
      if (blocking) {
        b_transport(memory.initiator, payload);
      } else {
        memory.initiator.send(payload);
      }
    });
    memory.clock.request(5);
    run(memory.clock, 2000);
    EXPECT_EQ(payload.get_response_status(), ::tlm::TLM_GENERIC_ERROR_RESPONSE);
    EXPECT_TRUE(memory.dram.idle());
  }
}

// A user's memory behind the bridge was called with it.
TEST_F(TargetRules, ANullDataPointerIsRefusedByTheBridge) {
  ClockDomain core("core", 1365.0);
  PortLinks links("port");
  unsigned accesses = 0;
  TlmToLink::Config config;
  config.data = [&](::tlm::tlm_generic_payload& payload) {
    ++accesses;
    payload.get_data_ptr()[0] = 1;
    return payload.get_data_length();
  };
  TlmToLink bridge("bridge", config, core);
  bridge.request.bind(links.request);
  bridge.response.bind(links.response);
  RawAtInitiator initiator("initiator");
  initiator.socket.bind(bridge.socket);
  elaborate();
  AtPayload& payload = initiator.payload(0x40);
  payload.set_data_ptr(nullptr);
  EXPECT_EQ(initiator.socket->transport_dbg(payload), 0u);
  EXPECT_EQ(b_transport(initiator, payload), ::tlm::TLM_GENERIC_ERROR_RESPONSE);
  payload.set_response_status(::tlm::TLM_INCOMPLETE_RESPONSE);
  initiator.send(payload);
  EXPECT_EQ(payload.get_response_status(), ::tlm::TLM_GENERIC_ERROR_RESPONSE);
  EXPECT_EQ(accesses, 0u);
  EXPECT_EQ(bridge.refused(), 2u);
}

}  // namespace
}  // namespace grtx::modules
