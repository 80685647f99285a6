// SPDX-License-Identifier: Apache-2.0
// Something between the GPU and its DRAM that gives the kernel events while the clocks run ahead of it.
#include <tlm_utils/peq_with_get.h>

#include "grtx/modules/dram/dram.h"
#include "grtx/modules/tlm/at_protocol_checker.h"
#include "modules/tlm/at_mocks.h"

namespace grtx::modules {
namespace {

/// Passes everything on, requests after a while: by an event of the kernel.
class Delayer final : public sc_core::sc_module {
 public:
  using SC_CURRENT_USER_MODULE = Delayer;  // SC_HAS_PROCESS, which SystemC 3 deprecates
  Delayer(const sc_core::sc_module_name& name, const sc_core::sc_time& by)
      : sc_module(name), target("target"), initiator("initiator"), by_(by) {
    target.register_nb_transport_fw(this, &Delayer::forward);
    initiator.register_nb_transport_bw(this, &Delayer::backward);
    SC_METHOD(send);
    sensitive << late_.get_event();
    dont_initialize();
  }
  tlm_utils::simple_target_socket<Delayer, 32> target;
  tlm_utils::simple_initiator_socket<Delayer, 32> initiator;

 private:
  ::tlm::tlm_sync_enum forward(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    if (phase != tlm::BEGIN_REQ) return initiator->nb_transport_fw(payload, phase, delay);
    late_.notify(payload, delay + by_);
    return ::tlm::TLM_ACCEPTED;
  }
  ::tlm::tlm_sync_enum backward(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase, sc_core::sc_time& delay) {
    return target->nb_transport_bw(payload, phase, delay);
  }
  void send() {
    while (::tlm::tlm_generic_payload* payload = late_.get_next_transaction()) {
      ::tlm::tlm_phase phase = tlm::BEGIN_REQ;
      sc_core::sc_time delay = sc_core::SC_ZERO_TIME;
      initiator->nb_transport_fw(*payload, phase, delay);
    }
  }

  sc_core::sc_time by_;
  tlm_utils::peq_with_get<::tlm::tlm_generic_payload> late_{"late"};
};

class DramInLine : public SystemCTest {
 protected:
  static std::vector<Cycle> answers(bool run_ahead, double delay_ns) {
    fresh_context();
    Dram::Config config;
    config.interleave.slices = 1;
    ClockDomain core("core", 1365.0);
    ClockDomain memory("memory", 3500.0);
    Dram dram("dram", config, memory);
    RunAhead ahead(core, memory, run_ahead);
    AtDriver driver("driver", core);
    AtProtocolChecker checker("checker", {.period_fs = core.period_fs()});
    Delayer delayer("delayer", sc_core::sc_time(delay_ns, sc_core::SC_NS));
    driver.initiator.socket.bind(checker.target);
    checker.initiator.bind(delayer.target);
    delayer.initiator.bind(dram.sockets[0]);
    for (unsigned i = 0; i < 200; ++i) driver.at(10 + 7 * i, i * 96 % 4096 / 32 * 32, i % 4 == 0);
    const sc_core::sc_time length = sc_core::sc_time::from_value(60'000 * core.period_fs());
    core.allow_ahead(length.value());
    sc_core::sc_start(length, sc_core::SC_RUN_TO_TIME);
    EXPECT_TRUE(driver.complete()) << "run-ahead " << run_ahead;
    EXPECT_TRUE(dram.idle());
    EXPECT_EQ(checker.violations(), 0u);
    std::vector<Cycle> cycles;
    for (std::uint32_t i = 0; i < 200; ++i) cycles.push_back(driver.answered(i));
    return cycles;
  }
};

// Clocks that run ahead looked once at what the kernel has to do, before they ran: the request that the component
// scheduled meanwhile came too late, and the model stood still.
TEST_F(DramInLine, AnInLineComponentThatSchedulesKernelEventsDoesNotDeadlockTheModel) {
  for (const double delay_ns : {0.3, 5.0, 100.0}) EXPECT_EQ(answers(true, delay_ns), answers(false, delay_ns));
}

}  // namespace
}  // namespace grtx::modules
