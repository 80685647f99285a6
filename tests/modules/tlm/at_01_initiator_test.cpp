// SPDX-License-Identifier: Apache-2.0
// AtInitiator: works with every behaviour that a base-protocol target may have, without a violation; back-pressure;
// payload pool.
#include "grtx/modules/tlm/at_payload_pool.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

class AtInitiatorTest : public SystemCTest {
 protected:
  struct Bench {
    explicit Bench(AtBehaviour behaviour)
        : core("core", 1365.0),
          memory("memory", 3500.0),
          driver("driver", core),
          checker("checker", {.period_fs = core.period_fs()}),
          target("target", memory, behaviour) {
      driver.initiator.socket.bind(checker.target);
      checker.initiator.bind(target.socket);
    }
    ClockDomain core;
    ClockDomain memory;
    AtDriver driver;
    AtProtocolChecker checker;
    MockAtTarget target;
  };
};

TEST_F(AtInitiatorTest, EveryLegalHabitOfATarget) {
  for (const AtBehaviour behaviour :
       {AtBehaviour::plain, AtBehaviour::withheld, AtBehaviour::no_end_request, AtBehaviour::updated,
        AtBehaviour::updated_response, AtBehaviour::completed, AtBehaviour::annotated, AtBehaviour::out_of_order,
        AtBehaviour::rewritten_address, AtBehaviour::auto_extension}) {
    fresh_context();
    Bench bench(behaviour);
    for (unsigned i = 0; i < 50; ++i) bench.driver.at(10 + i, 0x1000 + i * 32, i % 3 == 0);
    EXPECT_TRUE(run_until_quiet(bench.core, 100000));
    EXPECT_TRUE(bench.driver.complete()) << "behaviour " << static_cast<int>(behaviour);
    EXPECT_EQ(bench.checker.violations(), 0u)
        << "behaviour " << static_cast<int>(behaviour) << ": " << bench.checker.messages().front();
    EXPECT_EQ(bench.checker.transactions(), 50u);
    EXPECT_EQ(bench.checker.outstanding(), 0u);
    for (const auto& answer : bench.driver.answers()) {
      EXPECT_TRUE(answer.completion.ok());
      EXPECT_EQ(answer.completion.address, 0x1000 + answer.completion.context * 32) << "the address as it was sent";
      EXPECT_EQ(answer.completion.write, answer.completion.context % 3 == 0);
    }
    if (behaviour == AtBehaviour::auto_extension) {
      EXPECT_EQ(bench.target.extensions_freed(), 50u);
    }
  }
}

TEST_F(AtInitiatorTest, WithheldEndRequestIsTheBackPressure) {
  Bench bench(AtBehaviour::withheld);
  for (unsigned i = 0; i < 4; ++i) bench.driver.at(10, i * 32);
  EXPECT_TRUE(run_until_quiet(bench.core, 100000));
  const std::uint64_t core = bench.core.period_fs();
  const std::uint64_t memory = bench.memory.period_fs();
  Cycle sent = 10;
  for (unsigned i = 0; i < 4; ++i) {
    EXPECT_EQ(bench.driver.sent_at()[i], sent);
    const Cycle end_request = sent * core / memory + 1 + 500;  // first memory edge after the call, then 500 clocks
    sent = end_request * memory / core + 1;                    // first core edge after that
  }
}

TEST_F(AtInitiatorTest, PayloadsAreReused) {
  Bench bench(AtBehaviour::plain);
  for (unsigned i = 0; i < 1000; ++i) bench.driver.at(10 + i * 40, i * 32);
  EXPECT_TRUE(run_until_quiet(bench.core, 100000));
  EXPECT_TRUE(bench.driver.complete());
  EXPECT_LE(bench.driver.initiator.pool().allocated(), 4u);
}

TEST_F(AtInitiatorTest, AResponseIsSeenAtTheFirstCoreEdgeAfterIt) {
  Bench bench(AtBehaviour::plain);
  bench.driver.at(10, 0);
  EXPECT_TRUE(run_until_quiet(bench.core, 1000));
  const std::uint64_t core = bench.core.period_fs();
  const std::uint64_t memory = bench.memory.period_fs();
  const Cycle response = 10 * core / memory + 1 + MockAtTarget::kLatency;
  EXPECT_EQ(bench.driver.answered(0), response * memory / core + 1);
}

}  // namespace
}  // namespace grtx::modules
