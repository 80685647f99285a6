// SPDX-License-Identifier: Apache-2.0
// Crossbar between the SMs and the L2 slices: separate request and reply networks, one packet per port and cycle.
// Not in the paper; a simplification of GPGPU-Sim's built-in crossbar: every packet is one unit (flit) of 40 B.
// Polls each non-empty input port once per active cycle; sleeps when empty.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/index_set.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/kernel/ring_queue.h"
#include "grtx/modules/kernel/waiting_links.h"
#include "grtx/modules/messages/address_interleave.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/touch_if.h"

namespace grtx::modules {

struct CrossbarCounters;

/// The network as the GPU sees it: requests are routed by address to a slice, responses to their `sm`.
class CrossbarModule : public sc_core::sc_module {
 public:
  sc_core::sc_vector<LinkIn<MemoryRequest>> request_in;      ///< [sm]
  sc_core::sc_vector<LinkOut<MemoryRequest>> request_out;    ///< [slice]
  sc_core::sc_vector<LinkIn<MemoryResponse>> response_in;    ///< [slice]
  sc_core::sc_vector<LinkOut<MemoryResponse>> response_out;  ///< [sm]
  sc_core::sc_vector<TouchPort<touch_if>> touch_out;         ///< [slice]

  virtual CrossbarCounters counters() const = 0;
  /// Whether no packet is inside or waiting at the input ports.
  virtual bool idle() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  CrossbarModule(const char* name, unsigned sms, unsigned slices) = delete;  ///< see ClockedModule
  CrossbarModule(const sc_core::sc_module_name& name, unsigned sms, unsigned slices)
      : sc_module(name),
        request_in("request_in", sms),
        request_out("request_out", slices),
        response_in("response_in", slices),
        response_out("response_out", sms),
        touch_out("touch_out", slices) {}
};

struct CrossbarCounters {
  struct Network {
    std::uint64_t packets_in = 0;
    std::uint64_t packets_out = 0;
    std::uint64_t conflict_cycles = 0;  ///< input-cycles: the head packet lost the arbitration for its output
    std::uint64_t blocked_cycles = 0;   ///< input-cycles: the output buffer of the head packet was full
    static const CounterTable<Network>& table();
  };
  Network request;
  Network reply;
  OwnCounts own;  ///< extra counters of a user-supplied crossbar
};

/// Appends the counters as prefix + ".name".
void describe(const CrossbarCounters& counters, StatisticList& list, const std::string& prefix);

/// One direction: input-queued (the links are the queues), a round-robin arbiter per output, a delay of `latency`
/// cycles and a finite output buffer. Requests and replies have one each; they are independent, and each sleeps when
/// empty.
template <typename Packet>
class CrossbarNetwork final : public Clocked {
 public:
  CrossbarNetwork(ClockDomain& clock, const AddressInterleave& interleave, unsigned inputs, unsigned outputs,
                  unsigned latency, unsigned buffer)
      : interleave_(interleave),
        latency_(latency),
        inputs_(inputs),
        waiting_(inputs),
        outputs_(outputs),
        busy_(outputs),
        alarm_(clock, *this) {
    for (Output& output : outputs_) output.capacity = std::size_t{latency} + buffer;
  }
  void bind_input(unsigned i, const LinkReader<Packet>& link) {
    inputs_[i] = link;
    inputs_[i].wake(&alarm_);
    waiting_.watch(i, link);
  }
  /// The output link's own latency is part of the network's latency.
  void bind_output(unsigned i, const LinkWriter<Packet>& link) {
    outputs_[i].link = link;
    outputs_[i].hold = latency_ > link.latency() ? latency_ - link.latency() : 0;
  }
  Cycle tick(Cycle now) override;
  void restart(Caches) override {
    for (Output& output : outputs_) {
      output.buffer = RingQueue<Held>();
      output.next_input = 0;
    }
    busy_.clear();
    counters_ = {};
  }
  bool idle() const;
  const CrossbarCounters::Network& counters() const { return counters_; }
  void dump_state(std::ostream& out) const;

 private:
  struct Held {
    Packet packet;
    Cycle due = 0;
  };
  struct Output {
    LinkWriter<Packet> link;
    unsigned hold = 0;  ///< cycles between winning the arbitration and entering the link
    std::size_t capacity = 0;
    RingQueue<Held> buffer;
    unsigned next_input = 0;  ///< first in the round-robin order
    unsigned contenders = 0;  ///< in this cycle
    unsigned winner = 0;
    unsigned distance = 0;  ///< round-robin distance of the winner from next_input
  };

  unsigned destination(const Packet& packet) const;
  bool deliver(Cycle now, Output& output);

  AddressInterleave interleave_;
  unsigned latency_;
  std::vector<LinkReader<Packet>> inputs_;
  WaitingLinks waiting_;  ///< non-empty inputs_
  std::vector<Output> outputs_;
  IndexSet busy_;  ///< outputs with contenders or with packets in their buffers
  CrossbarCounters::Network counters_;
  Alarm alarm_;
};

class Crossbar final : public CrossbarModule, public touch_if {
 public:
  struct Config {
    unsigned sms = 8;  ///< set by the assembly
    AddressInterleave interleave{};
    unsigned latency = 8;         ///< cycles from visible at the input to visible at the output
    unsigned output_buffer = 32;  ///< packets per output, in addition to those in transit
    void parameters(ParameterList& list) {
      list.add("latency", latency, {1, kMaxLatency}, "cycles", "unloaded, each way", kOurs);
      list.add("output_buffer", output_buffer, {1, kMaxEntries}, "packets", "waiting at an output", kGpgpuSim);
    }
  };

  /// clock: core domain. Throws Error for an impossible configuration.
  Crossbar(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);

  Touched touch(const Touch& access) override;
  Inventory inventory() const override;
  void statistics(StatisticList& list, const std::string& prefix) const;
  CrossbarCounters counters() const override { return {requests_.counters(), replies_.counters(), {}}; }
  bool idle() const override;
  void dump_state(std::ostream& out) const override;
  const Config& config() const { return config_; }

 private:
  void end_of_elaboration() override;

  Config config_;
  CrossbarNetwork<MemoryRequest> requests_;
  CrossbarNetwork<MemoryResponse> replies_;
  std::vector<touch_if*> slices_;  ///< [slice]; empty unless the run is sampled
};

}  // namespace grtx::modules
