// SPDX-License-Identifier: Apache-2.0
// The monitor counts each transaction once, whichever way its phases take, and ends it when its response has ended.
#include "grtx/modules/tlm/at_monitor.h"

#include <tlm_utils/simple_initiator_socket.h>
#include <tlm_utils/simple_target_socket.h>

#include "modules/systemc_fixture.h"

namespace grtx::modules {
namespace {

using Payload = ::tlm::tlm_generic_payload;
using ::tlm::TLM_ACCEPTED;
using ::tlm::TLM_COMPLETED;
using ::tlm::TLM_UPDATED;

sc_core::sc_time ns(double count) { return {count, sc_core::SC_NS}; }

/// Answers a call as it is told to.
struct AnsweringTarget final : sc_core::sc_module {
  explicit AnsweringTarget(const sc_core::sc_module_name& name) : sc_module(name), socket("socket") {
    socket.register_nb_transport_fw(this, &AnsweringTarget::forward);
    socket.register_b_transport(this, &AnsweringTarget::blocking);
    socket.register_transport_dbg(this, &AnsweringTarget::debug);
  }
  ::tlm::tlm_sync_enum forward(Payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    if (phase != ::tlm::BEGIN_REQ) return TLM_ACCEPTED;
    payload.set_response_status(status);
    if (answer != TLM_ACCEPTED) {
      phase = answer_phase;
      delay += answer_delay;
    }
    return answer;
  }
  void blocking(Payload& payload, sc_core::sc_time& delay) {
    payload.set_response_status(status);
    delay += answer_delay;
  }
  unsigned debug(Payload&) { return 17; }
  ::tlm::tlm_sync_enum call(Payload& payload, ::tlm::tlm_phase phase, sc_core::sc_time delay = ns(0)) {
    return socket->nb_transport_bw(payload, phase, delay);
  }
  tlm_utils::simple_target_socket<AnsweringTarget, 32> socket;
  ::tlm::tlm_sync_enum answer = TLM_ACCEPTED;
  ::tlm::tlm_phase answer_phase = ::tlm::END_REQ;
  sc_core::sc_time answer_delay = ns(0);
  ::tlm::tlm_response_status status = ::tlm::TLM_OK_RESPONSE;
};

struct ToldInitiator final : sc_core::sc_module {
  explicit ToldInitiator(const sc_core::sc_module_name& name) : sc_module(name), socket("socket") {
    socket.register_nb_transport_bw(this, &ToldInitiator::backward);
  }
  ::tlm::tlm_sync_enum backward(Payload&, ::tlm::tlm_phase& phase, sc_core::sc_time&) {
    if (phase != ::tlm::BEGIN_RESP) return TLM_ACCEPTED;
    if (answer == TLM_UPDATED) phase = ::tlm::END_RESP;
    return answer;
  }
  ::tlm::tlm_sync_enum call(Payload& payload, ::tlm::tlm_phase phase, sc_core::sc_time delay = ns(0)) {
    return socket->nb_transport_fw(payload, phase, delay);
  }
  tlm_utils::simple_initiator_socket<ToldInitiator, 32> socket;
  ::tlm::tlm_sync_enum answer = TLM_UPDATED;  ///< to BEGIN_RESP
};

class AtMonitorTest : public SystemCTest {
 protected:
  AtMonitorTest() {
    initiator.socket.bind(monitor.target);
    monitor.initiator.bind(target.socket);
    elaborate();
  }
  static Payload& request(Payload& payload, bool write, unsigned bytes) {
    payload.set_command(write ? ::tlm::TLM_WRITE_COMMAND : ::tlm::TLM_READ_COMMAND);
    payload.set_data_length(bytes);
    payload.set_response_status(::tlm::TLM_INCOMPLETE_RESPONSE);
    return payload;
  }
  void expect(std::uint64_t reads, std::uint64_t writes, std::uint64_t bytes, std::uint64_t responses,
              std::uint64_t refused, bool idle, const char* when) {
    const MemoryTraffic& traffic = monitor.traffic();
    EXPECT_EQ(traffic.reads, reads) << when;
    EXPECT_EQ(traffic.writes, writes) << when;
    EXPECT_EQ(traffic.bytes, bytes) << when;
    EXPECT_EQ(traffic.responses, responses) << when;
    EXPECT_EQ(traffic.refused, refused) << when;
    EXPECT_EQ(monitor.outstanding(), reads + writes - responses) << when;
    EXPECT_EQ(monitor.idle(), idle) << when;
  }

  ToldInitiator initiator{"initiator"};
  AtMonitor monitor{"monitor"};
  AnsweringTarget target{"target"};
  Payload payload;
};

TEST_F(AtMonitorTest, BeforeAnythingNothingIsOutstandingAndTheMeanIsZero) {
  expect(0, 0, 0, 0, 0, true, "at first");
  EXPECT_EQ(monitor.mean_latency_ns(), 0.0);
}

TEST_F(AtMonitorTest, ACompletedRequestIsItsResponseToo) {
  target.answer = TLM_COMPLETED;
  target.answer_delay = ns(9);
  EXPECT_EQ(initiator.call(request(payload, true, 64), ::tlm::BEGIN_REQ, ns(2)), TLM_COMPLETED);
  expect(0, 1, 64, 1, 0, true, "after the call");
  EXPECT_DOUBLE_EQ(monitor.mean_latency_ns(), 9.0) << "2 to 11 ns";
}

TEST_F(AtMonitorTest, AResponseThatTheRequestReturnsEndsWithACall) {
  target.answer = TLM_UPDATED;
  target.answer_phase = ::tlm::BEGIN_RESP;
  target.answer_delay = ns(7);
  EXPECT_EQ(initiator.call(request(payload, false, 32), ::tlm::BEGIN_REQ), TLM_UPDATED);
  expect(1, 0, 32, 1, 0, false, "the response has begun");
  initiator.call(payload, ::tlm::END_RESP);
  expect(1, 0, 32, 1, 0, true, "the response has ended");
  EXPECT_DOUBLE_EQ(monitor.mean_latency_ns(), 7.0);
}

TEST_F(AtMonitorTest, TheEndOfARequestIsNoResponse) {
  target.answer = TLM_UPDATED;
  target.answer_phase = ::tlm::END_REQ;
  initiator.call(request(payload, false, 32), ::tlm::BEGIN_REQ);
  expect(1, 0, 32, 0, 0, false, "END_REQ was returned");
  EXPECT_EQ(target.call(payload, ::tlm::BEGIN_RESP), TLM_UPDATED);
  expect(1, 0, 32, 1, 0, true, "END_RESP was returned");
}

TEST_F(AtMonitorTest, AResponseByCallEndsAsTheInitiatorAnswers) {
  struct Case {
    ::tlm::tlm_sync_enum answer;
    bool ended;
  };
  std::uint64_t count = 0;
  for (const Case& c : {Case{TLM_UPDATED, true}, Case{TLM_COMPLETED, true}, Case{TLM_ACCEPTED, false}}) {
    initiator.answer = c.answer;
    initiator.call(request(payload, false, 32), ::tlm::BEGIN_REQ);
    expect(count + 1, 0, 32 * (count + 1), count, 0, false, "begun");
    target.call(payload, ::tlm::END_REQ);
    expect(count + 1, 0, 32 * (count + 1), count, 0, false, "taken");
    sc_core::sc_start(ns(40));
    EXPECT_EQ(target.call(payload, ::tlm::BEGIN_RESP, ns(5)), c.answer);
    ++count;
    expect(count, 0, 32 * count, count, 0, c.ended, "answered");
    if (!c.ended) initiator.call(payload, ::tlm::END_RESP);
    expect(count, 0, 32 * count, count, 0, true, "ended");
  }
  EXPECT_DOUBLE_EQ(monitor.mean_latency_ns(), 45.0);
}

TEST_F(AtMonitorTest, AnErrorIsAResponseAndRefused) {
  target.status = ::tlm::TLM_ADDRESS_ERROR_RESPONSE;
  target.answer_delay = ns(3);
  initiator.call(request(payload, false, 32), ::tlm::BEGIN_REQ);
  target.call(payload, ::tlm::BEGIN_RESP);
  expect(1, 0, 32, 1, 1, true, "by phases");
  sc_core::sc_time delay = ns(1);
  initiator.socket->b_transport(request(payload, true, 16), delay);
  expect(1, 1, 48, 2, 2, true, "by a blocking call");
  EXPECT_DOUBLE_EQ(monitor.mean_latency_ns(), 1.5) << "0 and 3 ns";
}

TEST_F(AtMonitorTest, ADebugAccessPassesUncounted) {
  EXPECT_EQ(initiator.socket->transport_dbg(request(payload, false, 32)), 17u);
  expect(0, 0, 0, 0, 0, true, "after it");
}

}  // namespace
}  // namespace grtx::modules
