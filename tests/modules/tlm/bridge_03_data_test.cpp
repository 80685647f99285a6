// SPDX-License-Identifier: Apache-2.0
// Data before and behind the bridges: what an initiator writes it reads, and what others hold stays.
#include <tlm_utils/simple_initiator_socket.h>
#include <tlm_utils/simple_target_socket.h>

#include "grtx/modules/kernel/link.h"
#include "grtx/modules/tlm/functional_memory.h"
#include "grtx/modules/tlm/link_to_tlm.h"
#include "grtx/modules/tlm/tlm_to_link.h"
#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

/// A loosely timed memory with data, 4 KiB of which exist.
class DataMemory final : public sc_core::sc_module {
 public:
  explicit DataMemory(const sc_core::sc_module_name& name) : sc_module(name), socket("socket") {
    socket.register_b_transport(this, &DataMemory::b_transport);
    socket.register_transport_dbg(this, &DataMemory::transport_dbg);
  }
  tlm_utils::simple_target_socket<DataMemory, 32> socket;
  unsigned transport_dbg(::tlm::tlm_generic_payload& payload) {
    return payload.get_address() + payload.get_data_length() > 4096 ? 0 : memory_.access(payload);
  }
  unsigned char at(std::uint64_t address) {
    unsigned char byte = 0;
    ::tlm::tlm_generic_payload payload;
    payload.set_command(::tlm::TLM_READ_COMMAND);
    payload.set_address(address);
    payload.set_data_ptr(&byte);
    payload.set_data_length(1);
    memory_.access(payload);
    return byte;
  }

 private:
  void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay) {
    delay += sc_core::sc_time(50, sc_core::SC_NS);
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    memory_.access(payload);
  }
  FunctionalMemory memory_;
};

/// Initiator -> TlmToLink -> links -> LinkToTlm -> a memory.
class BridgeData : public SystemCTest {
 protected:
  struct Bench final : sc_core::sc_module {
    using SC_CURRENT_USER_MODULE = Bench;
    explicit Bench(bool through, const sc_core::sc_module_name& name = "bench")
        : sc_module(name),
          core("core", 1365.0),
          memory("memory"),
          front("front", config(through), core),
          back("back", {.blocking = true}, core) {
      initiator.bind(front.socket);
      front.request.bind(requests);
      front.response.bind(responses);
      back.request.bind(requests);
      back.response.bind(responses);
      back.memory.socket.bind(memory.socket);
      SC_THREAD(run);
    }
    TlmToLink::Config config(bool through) {
      TlmToLink::Config config;
      if (through) config.data = [this](::tlm::tlm_generic_payload& payload) { return memory.transport_dbg(payload); };
      return config;
    }
    ::tlm::tlm_response_status access(::tlm::tlm_command command, std::uint64_t address, unsigned char& byte) {
      ::tlm::tlm_generic_payload payload;
      set(payload, command, address, byte);
      sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
      initiator->b_transport(payload, delay);
      return payload.get_response_status();
    }
    static void set(::tlm::tlm_generic_payload& payload, ::tlm::tlm_command command, std::uint64_t address,
                    unsigned char& byte) {
      payload.set_command(command);
      payload.set_address(address);
      payload.set_data_ptr(&byte);
      payload.set_data_length(1);
      payload.set_streaming_width(1);
    }
    void run() { body(); }
    std::function<void()> body = [] {};
    ClockDomain core;
    DataMemory memory;
    Link<MemoryRequest> requests{"requests", 1, 4};
    Link<MemoryResponse> responses{"responses", 1, 4};
    tlm_utils::simple_initiator_socket<Bench, 32> initiator{"initiator"};
    TlmToLink front;
    LinkToTlm back;
  };
};

TEST_F(BridgeData, AWriteOf0xabReads0xab) {
  for (const bool through : {false, true}) {
    fresh_context();
    Bench bench(through);
    bool done = false;
    bench.body = [&] {
      unsigned char byte = 0xab;
      EXPECT_EQ(bench.access(::tlm::TLM_WRITE_COMMAND, 0x123, byte), ::tlm::TLM_OK_RESPONSE);
      byte = 0;
      EXPECT_EQ(bench.access(::tlm::TLM_READ_COMMAND, 0x123, byte), ::tlm::TLM_OK_RESPONSE);
      EXPECT_EQ(byte, 0xab);
      byte = 0;
      ::tlm::tlm_generic_payload payload;
      Bench::set(payload, ::tlm::TLM_READ_COMMAND, 0x123, byte);
      EXPECT_EQ(bench.initiator->transport_dbg(payload), 1u);
      EXPECT_EQ(byte, 0xab);
      ::tlm::tlm_dmi dmi;
      EXPECT_FALSE(bench.initiator->get_direct_mem_ptr(payload, dmi));
      done = true;
    };
    elaborate();
    EXPECT_TRUE(run_until_quiet(bench.core, 10000));
    EXPECT_TRUE(done);
    EXPECT_EQ(bench.memory.at(0x123), through ? 0xab : 0);
  }
}

// A sector is 32 B, of which the initiator writes one.
TEST_F(BridgeData, AWriteLeavesWhatOthersHoldInTheSector) {
  Bench bench(true);
  bench.body = [&] {
    unsigned char theirs = 0x77, ours = 0xab;
    ::tlm::tlm_generic_payload payload;
    Bench::set(payload, ::tlm::TLM_WRITE_COMMAND, 0x130, theirs);
    bench.memory.transport_dbg(payload);
    bench.access(::tlm::TLM_WRITE_COMMAND, 0x123, ours);
  };
  elaborate();
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(bench.memory.at(0x130), 0x77);
  EXPECT_EQ(bench.memory.at(0x123), 0xab);
}

TEST_F(BridgeData, WhatTheMemoryBehindDoesNotHaveIsAnAddressError) {
  Bench bench(true);
  ::tlm::tlm_response_status status = ::tlm::TLM_INCOMPLETE_RESPONSE;
  bench.body = [&] {
    unsigned char byte = 0;
    status = bench.access(::tlm::TLM_READ_COMMAND, 0x2000, byte);
  };
  elaborate();
  EXPECT_TRUE(run_until_quiet(bench.core, 10000));
  EXPECT_EQ(status, ::tlm::TLM_ADDRESS_ERROR_RESPONSE);
}

}  // namespace
}  // namespace grtx::modules
