// SPDX-License-Identifier: Apache-2.0
// END_RESP: a forward call that takes effect one clock after BEGIN_RESP, whatever the target's clock.
#include <deque>

#include "grtx/modules/dram/dram.h"
#include "grtx/modules/tlm/at_initiator.h"
#include "grtx/modules/tlm/at_payload_pool.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

/// A target that lives on a time grid of its own, as DRAMSys 5.1 does: calls are rounded up to it, but a delay that is
/// returned with END_RESP is not, and off the grid nothing ever looks at it.
class GridTarget final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = GridTarget;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  GridTarget(const sc_core::sc_module_name& name, std::uint64_t grid_fs)
      : sc_module(name), socket("socket"), grid_fs_(grid_fs) {
    socket.register_nb_transport_fw(this, &GridTarget::nb_transport_fw);
    SC_METHOD(act);
    sensitive << wake_;
    dont_initialize();
  }
  tlm_utils::simple_target_socket<GridTarget, 32> socket;
  std::vector<std::uint64_t> response_ends;  ///< times of END_RESP as they were called, fs
  std::vector<std::uint64_t> response_begins;

 private:
  using Payload = ::tlm::tlm_generic_payload;

  std::uint64_t now() const { return sc_core::sc_time_stamp().value(); }
  std::uint64_t on_grid(std::uint64_t fs) const { return (fs + grid_fs_ - 1) / grid_fs_ * grid_fs_; }
  void at(std::uint64_t fs, std::function<void()> action) {
    actions_.emplace(fs, std::move(action));
    wake_.notify(sc_core::sc_time::from_value(actions_.begin()->first - now()));
  }
  void act() {
    while (!actions_.empty() && actions_.begin()->first <= now()) {
      const std::function<void()> action = std::move(actions_.begin()->second);
      actions_.erase(actions_.begin());
      action();
    }
    if (!actions_.empty()) wake_.notify(sc_core::sc_time::from_value(actions_.begin()->first - now()));
  }
  ::tlm::tlm_sync_enum nb_transport_fw(Payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    const std::uint64_t called = now() + delay.value();
    if (phase == tlm::BEGIN_REQ) {
      payload.acquire();
      at(on_grid(called), [this, &payload] { take(payload); });
    } else if (phase == tlm::END_RESP) {
      response_ends.push_back(called);
      at(on_grid(called), [this, &payload] { end(payload); });
    }
    return ::tlm::TLM_ACCEPTED;
  }
  void take(Payload& payload) {
    ::tlm::tlm_phase phase = tlm::END_REQ;
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    socket->nb_transport_bw(payload, phase, delay);
    at(now() + 20 * grid_fs_, [this, &payload] {
      done_.push_back(&payload);
      respond();
    });
  }
  void respond() {
    if (responding_ || done_.empty()) return;
    Payload& payload = *done_.front();
    done_.pop_front();
    responding_ = true;
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    ::tlm::tlm_phase phase = tlm::BEGIN_RESP;
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    response_begins.push_back(now());
    const ::tlm::tlm_sync_enum status = socket->nb_transport_bw(payload, phase, delay);
    if (status == ::tlm::TLM_ACCEPTED) return;
    const std::uint64_t ends = now() + delay.value();
    if (ends % grid_fs_ == 0) at(ends, [this, &payload] { end(payload); });
  }
  void end(Payload& payload) {
    responding_ = false;
    payload.release();
    respond();
  }

  std::uint64_t grid_fs_;
  sc_core::sc_event wake_;
  std::multimap<std::uint64_t, std::function<void()>> actions_;
  std::deque<Payload*> done_;
  bool responding_ = false;
};

class AtEndResponse : public SystemCTest {};

// World: DRAMSys 5.1 (tCK 1 ns for HBM2) hung after its first response at 1365 MHz, and worked at 1000 and 500 MHz.
TEST_F(AtEndResponse, ATargetWithATimeGridOfItsOwnDoesNotHangAfterTheFirstResponse) {
  for (const double mhz : {1365.0, 1000.0, 500.0, 933.3}) {
    for (const std::uint64_t grid_fs : {1'000'000U, 571'428U, 1'071'999U}) {
      fresh_context();
      ClockDomain core("core", mhz);
      AtDriver driver("driver", core);
      AtProtocolChecker checker("checker", {.period_fs = core.period_fs()});
      GridTarget target("target", grid_fs);
      driver.initiator.socket.bind(checker.target);
      checker.initiator.bind(target.socket);
      for (unsigned i = 0; i < 50; ++i) driver.at(10 + i, i * 32, i % 3 == 0);
      EXPECT_TRUE(run_until_quiet(core, 100000));
      EXPECT_TRUE(driver.complete()) << mhz << " MHz, " << grid_fs << " fs";
      EXPECT_EQ(checker.violations(), 0u) << checker.messages().front();
      ASSERT_EQ(target.response_ends.size(), 50u);
      for (unsigned i = 0; i < 50; ++i) {
        EXPECT_EQ(target.response_ends[i], target.response_begins[i] + core.period_fs()) << "exactly one clock later";
      }
    }
  }
}

TEST_F(AtEndResponse, ReturningItWithADelayHangsThatTargetUnlessTheClocksMatch) {
  struct Case {
    std::uint64_t delay_fs;
    std::size_t responses;
  };
  for (const Case& c : {Case{1'000'000, 3}, Case{732'601, 1}}) {
    fresh_context();
    ClockDomain clock("clock", 100.0);
    RawAtInitiator initiator("initiator");  // returns TLM_UPDATED
    initiator.end_response_after = sc_core::sc_time::from_value(c.delay_fs);
    GridTarget target("target", 1'000'000);
    initiator.socket.bind(target.socket);
    TickProcess starter("starter", clock, [&](Cycle now) { initiator.send(initiator.payload(now * 32)); });
    for (const Cycle cycle : {1U, 2U, 3U}) clock.request(cycle);
    EXPECT_TRUE(run_until_quiet(clock, 1000));
    EXPECT_EQ(target.response_begins.size(), c.responses) << c.delay_fs;
  }
}

TEST_F(AtEndResponse, IsSentWhileTheModuleThatOwnsTheSocketDoesNotTakeItsCompletions) {
  struct Owner final : sc_core::sc_module {
    Owner(const sc_core::sc_module_name& name, ClockDomain& clock) : sc_module(name), initiator("socket", clock) {}
    AtInitiator initiator;
  };
  ClockDomain core("core", 1365.0);
  Owner owner("owner", core);
  AtInitiator& initiator = owner.initiator;
  GridTarget target("target", 1'000'000);
  initiator.socket.bind(target.socket);
  TickProcess sender("sender", core, [&](Cycle now) {
    initiator.update(now);
    if (initiator.can_send(now) && initiator.pool().live() + initiator.completions() < 4) {
      initiator.send(now * 32, 32, false, 0);
    }
  });
  for (const Cycle cycle : {1U, 50U, 100U}) core.request(cycle);
  EXPECT_TRUE(run_until_quiet(core, 10000));
  EXPECT_EQ(target.response_ends.size(), 4u);
  EXPECT_EQ(initiator.completions(), 4u);
  EXPECT_EQ(initiator.pool().live(), 0u);
}

/// Takes every request at once and answers when it is told to.
class ToldTarget final : public sc_core::sc_module {
 public:
  explicit ToldTarget(const sc_core::sc_module_name& name) : sc_module(name), socket("socket") {
    socket.register_nb_transport_fw(this, &ToldTarget::nb_transport_fw);
  }
  tlm_utils::simple_target_socket<ToldTarget, 32> socket;
  std::deque<::tlm::tlm_generic_payload*> taken;

  void respond() {
    ::tlm::tlm_generic_payload& payload = *taken.front();
    taken.pop_front();
    respond(payload);
  }
  void respond(::tlm::tlm_generic_payload& payload) {
    ::tlm::tlm_phase phase = tlm::BEGIN_RESP;
    sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
    payload.set_response_status(::tlm::TLM_OK_RESPONSE);
    socket->nb_transport_bw(payload, phase, delay);
  }

 private:
  ::tlm::tlm_sync_enum nb_transport_fw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time&) {
    if (phase != tlm::BEGIN_REQ) return ::tlm::TLM_ACCEPTED;
    taken.push_back(&payload);
    phase = tlm::END_REQ;
    return ::tlm::TLM_UPDATED;
  }
};

TEST_F(AtEndResponse, AResponseThatOverlapsThePreviousOneIsReported) {
  ClockDomain core("core", 1000.0);
  AtDriver driver("driver", core);
  ToldTarget target("target");
  driver.initiator.socket.bind(target.socket);
  for (unsigned i = 0; i < 3; ++i) driver.at(10, i * 32);
  TickProcess teller("teller", core, [&](Cycle now) {
    if (now != 50) return;
    ASSERT_EQ(target.taken.size(), 3u);
    target.respond();
    try {
      target.respond();
      FAIL() << "the second response was taken";
    } catch (const sc_core::sc_report& report) {
      EXPECT_EQ(std::string(report.get_msg()),
                std::string(driver.initiator.socket.name()) + ": BEGIN_RESP before END_RESP of the previous response");
    }
  });
  core.request(50);
  run(core, 100);
  EXPECT_NE(driver.answered(0), kNever);
}

// Where reports do not throw, the payload of the first response was lost and null was dereferenced.
TEST_F(AtEndResponse, AResponseOutOfTurnIsAsIfItHadNotBeenSentWhereReportsDoNotThrow) {
  ClockDomain core("core", 1000.0);
  AtDriver driver("driver", core);
  ToldTarget target("target");
  driver.initiator.socket.bind(target.socket);
  for (unsigned i = 0; i < 2; ++i) driver.at(10, i * 32);
  TickProcess teller("teller", core, [&](Cycle now) {
    if (now == 50) {
      target.respond(*target.taken[0]);
      target.respond(*target.taken[0]);  // a second one of the request
      target.respond(*target.taken[1]);  // before END_RESP of the first
    }
    if (now == 60) target.respond(*target.taken[1]);
  });
  core.request(50);
  core.request(60);
  sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_DO_NOTHING);
  run(core, 100);
  sc_core::sc_report_handler::set_actions(sc_core::SC_ERROR, sc_core::SC_DEFAULT_ERROR_ACTIONS);
  EXPECT_EQ(driver.answers().size(), 2u);
  EXPECT_TRUE(driver.initiator.idle());
}

}  // namespace
}  // namespace grtx::modules
