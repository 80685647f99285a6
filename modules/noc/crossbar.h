// Crossbar between the SMs and the L2 slices: separate request and reply networks, one packet per port and cycle.
// Not in the paper; a simplification of GPGPU-Sim's built-in crossbar (hardware.md 9.3): one 40 B flit a packet.
// Costs one look at each input port's head per active cycle; sleeps when empty.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/index_set.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/kernel/statistics.h"
#include "grtx/modules/kernel/waiting_links.h"
#include "grtx/modules/messages/address_interleave.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

struct CrossbarCounters {
  struct Network {
    std::uint64_t packets_in = 0;
    std::uint64_t packets_out = 0;
    std::uint64_t conflict_cycles = 0;  ///< a head packet lost the arbitration for its output
    std::uint64_t blocked_cycles = 0;   ///< a head packet's output buffer was full
  };
  Network request;
  Network reply;
};

/// Adds the counts as prefix + ".name".
void describe(const CrossbarCounters& counters, StatisticList& list, const std::string& prefix);

/// One direction: input-queued (the links are the queues), a round-robin arbiter per output, a delay of `latency`
/// cycles and a finite output buffer. Plain C++; the module drives one for requests and one for replies.
template <typename Packet>
class CrossbarNetwork {
 public:
  CrossbarNetwork(unsigned inputs, unsigned outputs, unsigned latency, unsigned buffer)
      : latency_(latency), inputs_(inputs), waiting_(inputs), outputs_(outputs), busy_(outputs) {
    for (Output& output : outputs_) output.capacity = std::size_t{latency} + buffer;
  }
  void bind_input(unsigned i, Link<Packet>* link) {
    inputs_[i] = link;
    waiting_.watch(i, *link);
  }
  /// The output link's own latency is part of the network's latency.
  void bind_output(unsigned i, Link<Packet>* link) {
    outputs_[i].link = link;
    outputs_[i].hold = latency_ > link->latency() ? latency_ - link->latency() : 0;
  }
  /// One cycle. destination(packet) gives the output; returns the next cycle with work, kNever when empty.
  template <typename Destination>
  Cycle step(Cycle now, ClockDomain& clock, const Destination& destination);
  bool idle() const;
  const CrossbarCounters::Network& counters() const { return counters_; }
  void dump_state(std::ostream& out) const;

 private:
  struct Held {
    Packet packet;
    Cycle due = 0;
  };
  struct Output {
    Link<Packet>* link = nullptr;
    unsigned hold = 0;  ///< cycles between winning the arbitration and entering the link
    std::size_t capacity = 0;
    RingQueue<Held> buffer;
    unsigned next_input = 0;  ///< first in the round-robin order
    unsigned contenders = 0;  ///< in the present cycle
    unsigned winner = 0;
    unsigned distance = 0;  ///< of the winner from next_input, in the round-robin order
  };

  bool deliver(Cycle now, ClockDomain& clock, Output& output);

  unsigned latency_;
  std::vector<Link<Packet>*> inputs_;
  WaitingLinks waiting_;  ///< of inputs_
  std::vector<Output> outputs_;
  IndexSet busy_;  ///< outputs with contenders or with packets in their buffers
  CrossbarCounters::Network counters_;
};

class Crossbar final : public sc_core::sc_module {
 public:
  struct Config {
    unsigned sms = 8;  ///< paper Table I [A]
    AddressInterleave interleave{};
    unsigned latency = 8;         ///< cycles from input visible to output visible, unloaded, each way [D]
    unsigned output_buffer = 32;  ///< packets waiting at an output beyond those in transit; hardware.md 9.3 [C]
  };

  SC_HAS_PROCESS(Crossbar);
  /// clock: core domain. Throws Error for an impossible configuration.
  Crossbar(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);

  sc_core::sc_vector<sc_core::sc_port<Link<MemoryRequest>>> request_in;     ///< [sm]
  sc_core::sc_vector<sc_core::sc_port<Link<MemoryRequest>>> request_out;    ///< [slice]
  sc_core::sc_vector<sc_core::sc_port<Link<MemoryResponse>>> response_in;   ///< [slice]
  sc_core::sc_vector<sc_core::sc_port<Link<MemoryResponse>>> response_out;  ///< [sm]

  Inventory inventory() const;
  void statistics(StatisticList& list, const std::string& prefix) const;
  CrossbarCounters counters() const { return {requests_.counters(), replies_.counters()}; }
  bool idle() const;
  void dump_state(std::ostream& out) const;
  const Config& config() const { return config_; }

 private:
  void end_of_elaboration() override;
  void tick_requests();
  void tick_replies();

  Config config_;
  ClockDomain& clock_;
  Alarm request_alarm_;
  Alarm reply_alarm_;
  CrossbarNetwork<MemoryRequest> requests_;
  CrossbarNetwork<MemoryResponse> replies_;
};

}  // namespace grtx::modules
