// SPDX-License-Identifier: Apache-2.0
// AtProtocolChecker: each forbidden behaviour of a target, and each wrong request, is reported with its clause.
#include <gmock/gmock.h>

#include "grtx/modules/tlm/at_payload_pool.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class AtProtocolCheckerTest : public SystemCTest {};

TEST_F(AtProtocolCheckerTest, CatchesWrongTargets) {
  struct Case {
    AtBehaviour behaviour;
    const char* clause;
  };
  const Case cases[] = {{AtBehaviour::no_status, "14.17"},
                        {AtBehaviour::two_responses, "15.2.4"},
                        {AtBehaviour::changed_length, "14.7"},
                        {AtBehaviour::late_end_request, "15.2.4"},
                        {AtBehaviour::backward_delay, "15.2.7 c"},
                        {AtBehaviour::wrong_phase, "15.2.3 c"},
                        {AtBehaviour::overlapping_responses, "15.2.6 f"}};
  for (const Case& c : cases) {
    fresh_context();
    ClockDomain memory("memory", 3500.0);
    RawAtInitiator initiator("initiator");
    // Answers BEGIN_RESP late where the target must not begin another response meanwhile.
    if (c.behaviour == AtBehaviour::overlapping_responses || c.behaviour == AtBehaviour::two_responses) {
      initiator.answer = ::tlm::TLM_ACCEPTED;
    }
    AtProtocolChecker checker("checker", {});
    MockAtTarget target("target", memory, c.behaviour);
    initiator.socket.bind(checker.target);
    checker.initiator.bind(target.socket);
    TickProcess starter("starter", memory, [&](Cycle now) {
      if (now == 5) initiator.send(initiator.payload(0));
      if (now == 20 && c.behaviour == AtBehaviour::overlapping_responses) initiator.send(initiator.payload(32));
    });
    memory.request(5);
    memory.request(20);
    run(memory, 200);
    EXPECT_GE(checker.violations(), 1u) << c.clause;
    EXPECT_THAT(checker.messages(), Contains(HasSubstr(c.clause)));
  }
}

TEST_F(AtProtocolCheckerTest, CatchesWrongRequests) {
  struct Case {
    const char* clause;
    std::function<void(AtPayload&)> spoil;
  };
  static unsigned char enables = 0xFF;
  const Case cases[] = {
      {"14.11 e", [](AtPayload& p) { p.set_data_ptr(nullptr); }},
      {"14.12 d", [](AtPayload& p) { p.set_data_length(0); }},
      {"14.14 f", [](AtPayload& p) { p.set_byte_enable_ptr(&enables); }},
      {"14.15 f", [](AtPayload& p) { p.set_streaming_width(0); }},
      {"14.16", [](AtPayload& p) { p.set_dmi_allowed(true); }},
      {"14.17 e", [](AtPayload& p) { p.set_response_status(::tlm::TLM_OK_RESPONSE); }},
      {"14.8 g", [](AtPayload& p) { p.set_gp_option(::tlm::TLM_FULL_PAYLOAD); }},
      {"not a power of two", [](AtPayload& p) { p.set_data_length(96), p.set_streaming_width(96); }},
      {"not naturally aligned", [](AtPayload& p) { p.set_address(16); }},
      {"streaming width differs", [](AtPayload& p) { p.set_streaming_width(16); }},
      {"beyond the memory", [](AtPayload& p) { p.set_address(1 << 20); }},
  };
  ClockDomain memory("memory", 3500.0);
  RawAtInitiator initiator("initiator");
  AtProtocolChecker checker("checker", {.address_limit = 1 << 20});
  MockAtTarget target("target", memory, AtBehaviour::plain);
  initiator.socket.bind(checker.target);
  checker.initiator.bind(target.socket);
  std::size_t next = 0;
  TickProcess starter("starter", memory, [&](Cycle now) {
    if (now % 100 != 0 || next == std::size(cases)) return;
    AtPayload& payload = initiator.payload(0);
    cases[next].spoil(payload);
    const std::uint64_t before = checker.violations();
    initiator.send(payload);
    EXPECT_GE(checker.violations(), before + 1) << cases[next].clause;
    EXPECT_THAT(checker.messages().at(before), ::testing::_);
    bool found = false;
    for (std::size_t m = before; m < checker.messages().size(); ++m) {
      found = found || checker.messages()[m].find(cases[next].clause) != std::string::npos;
    }
    EXPECT_TRUE(found) << cases[next].clause;
    ++next;
    memory.request(now + 100);
  });
  memory.request(100);
  EXPECT_TRUE(run_until_quiet(memory, 10000));
  EXPECT_EQ(next, std::size(cases));
}

TEST_F(AtProtocolCheckerTest, CatchesWrongInitiators) {
  ClockDomain memory("memory", 3500.0);
  RawAtInitiator initiator("initiator");
  AtProtocolChecker checker("checker", {.period_fs = 5'000'000});
  MockAtTarget target("target", memory, AtBehaviour::plain);
  initiator.socket.bind(checker.target);
  checker.initiator.bind(target.socket);
  tlm::tlm_generic_payload bare;
  std::array<unsigned char, 32> data{};
  bare.set_read();
  bare.set_data_ptr(data.data());
  bare.set_data_length(32);
  bare.set_streaming_width(32);
  const auto reported = [&](const char* what) {
    return std::any_of(checker.messages().begin(), checker.messages().end(),
                       [&](const std::string& m) { return m.find(what) != std::string::npos; });
  };
  TickProcess starter("starter", memory, [&](Cycle now) {
    if (now == 10) {
      AtPayload& first = initiator.payload(0);
      initiator.send(first);
      EXPECT_EQ(checker.violations(), 0u);
      initiator.send(initiator.payload(32));
      EXPECT_TRUE(reported("15.2.6 e")) << "a second request before END_REQ";
      initiator.send(first);
      EXPECT_TRUE(reported("14.5 x")) << "a payload in use";
    }
    if (now == 400) {
      initiator.send(bare);
      EXPECT_TRUE(reported("14.5 i")) << "no memory manager";
    }
    if (now == 450) {
      const std::uint64_t before = checker.violations();
      initiator.send(bare, tlm::END_REQ);
      EXPECT_GT(checker.violations(), before) << "END_REQ does not travel forward";
    }
    if (now == 500) {
      AtPayload& payload = initiator.payload(64);
      sc_core::sc_time delay;
      initiator.socket->b_transport(payload, delay);
      EXPECT_TRUE(reported("11.1.1.4 b")) << "b_transport from an SC_METHOD";
    }
  });
  for (const Cycle c : {10u, 400u, 450u, 500u}) memory.request(c);
  run(memory, 600);
  EXPECT_TRUE(reported("END_RESP less than one clock after BEGIN_RESP"));
}

TEST_F(AtProtocolCheckerTest, CompletedForBeginRespIsLegalButHangsDramSimulators) {
  for (const bool project_rules : {true, false}) {
    fresh_context();
    ClockDomain memory("memory", 3500.0);
    RawAtInitiator initiator("initiator");
    initiator.answer = ::tlm::TLM_COMPLETED;
    AtProtocolChecker checker("checker", {.project_rules = project_rules});
    MockAtTarget target("target", memory, AtBehaviour::plain);
    initiator.socket.bind(checker.target);
    checker.initiator.bind(target.socket);
    TickProcess starter("starter", memory, [&](Cycle now) {
      if (now == 5) initiator.send(initiator.payload(0));
    });
    memory.request(5);
    run(memory, 200);
    EXPECT_EQ(checker.violations(), project_rules ? 1u : 0u);
    EXPECT_EQ(checker.outstanding(), 0u);
  }
}

}  // namespace
}  // namespace grtx::modules
