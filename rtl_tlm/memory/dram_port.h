// SPDX-License-Identifier: Apache-2.0
// The target side of one L2 slice's DRAM socket, in front of an external DRAM simulator: request phase with
// back-pressure, response phase, fixed latency, counts. TLM-2.0 AT base protocol, as the built-in Dram speaks it, and
// like it without data.
#pragma once

#include <tlm_utils/simple_target_socket.h>
#include <cstdint>
#include <iosfwd>
#include <systemc>
#include <tlm>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/ring_queue.h"

namespace grtx::sim {

struct DramPortCounters {
  std::uint64_t reads = 0;  ///< requests that the simulator took
  std::uint64_t writes = 0;
  std::uint64_t bytes = 0;
  std::uint64_t responses = 0;
  std::uint64_t refused = 0;        ///< malformed requests, answered with an error status
  std::uint64_t full_clocks = 0;    ///< clocks in which a request waited for the simulator, END_REQ withheld
  std::uint64_t inside_clocks = 0;  ///< requests inside the simulator, summed over clocks
  DramPortCounters& operator+=(const DramPortCounters& other);
};

/// A member of a clocked module, which drives it from its tick: arrived(), accept() or refuse(), complete(), step().
class DramPort {
 public:
  struct Config {
    std::uint64_t longest = 256;  ///< longest request in bytes; longer ones are refused
    std::uint64_t bytes = 0;      ///< addresses beyond are refused; 0: unlimited
    Cycle fixed_latency = 0;      ///< clocks added to every response
  };

  /// alarm: the module's alarm, which is set when a phase arrives.
  DramPort(const char* name, const Config& config, modules::ClockDomain& clock, modules::Alarm& alarm);

  tlm_utils::simple_target_socket<DramPort, 32> socket;  ///< addresses are global

  /// The request that waits for END_REQ at clock `now`, else nullptr. Malformed requests are refused here.
  const ::tlm::tlm_generic_payload* arrived(Cycle now);
  /// Call when the simulator has taken the request: sends END_REQ. complete() follows, once.
  ::tlm::tlm_generic_payload& accept(Cycle now);
  /// Call when the simulator has answered, in any order of requests: the response goes out after the fixed latency.
  void complete(::tlm::tlm_generic_payload& payload, Cycle now, bool ok);
  /// Begins a response when one is due. Returns the next clock in which this port has work, arrivals included.
  Cycle step(Cycle now);

  std::uint64_t outstanding() const { return outstanding_; }  ///< requests begun, responses not begun
  bool idle() const { return outstanding_ == 0 && responding_ == nullptr; }
  const DramPortCounters& counters() const { return counters_; }
  void dump_state(std::ostream& out) const;

 private:
  struct Response {
    ::tlm::tlm_generic_payload* payload = nullptr;
    Cycle due = 0;
  };
  ::tlm::tlm_sync_enum nb_transport_fw(::tlm::tlm_generic_payload& payload, ::tlm::tlm_phase& phase,
                                       sc_core::sc_time& delay);
  void b_transport(::tlm::tlm_generic_payload& payload, sc_core::sc_time& delay);
  ::tlm::tlm_sync_enum reject(::tlm::tlm_generic_payload& payload, const char* rule) const;
  ::tlm::tlm_response_status check(const ::tlm::tlm_generic_payload& payload) const;
  ::tlm::tlm_generic_payload& end_request();
  void count_inside(Cycle now);

  Config config_;
  modules::ClockDomain& clock_;
  modules::Alarm& alarm_;
  ::tlm::tlm_generic_payload* arriving_ = nullptr;
  Cycle arrival_ = 0;  ///< clock from which it is seen
  modules::RingQueue<Response> responses_;
  ::tlm::tlm_generic_payload* responding_ = nullptr;
  Cycle response_free_ = 0;  ///< clock from which the next response may begin
  std::uint64_t outstanding_ = 0;
  std::uint64_t inside_ = 0;  ///< taken, not completed
  Cycle counted_ = 0;         ///< clock to which inside_clocks is summed
  DramPortCounters counters_;
};

}  // namespace grtx::sim
