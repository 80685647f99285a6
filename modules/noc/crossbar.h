// SPDX-License-Identifier: Apache-2.0
// Crossbar between the SMs and the L2 slices: separate request and reply networks, one packet per port and cycle.
// Not in the paper; a simplification of GPGPU-Sim's built-in crossbar: every packet is one unit (flit) of 40 B.
// Polls each non-empty input port once per active cycle; sleeps when empty.
#pragma once

#include <algorithm>
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
#include "grtx/modules/noc/crossbar_if.h"

namespace grtx::modules {

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
        due_(outputs, kNever),
        contended_(outputs),
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
      output.contenders = 0;
    }
    std::fill(due_.begin(), due_.end(), kNever);
    contended_.clear();
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
  void deliver(Cycle now, unsigned output);

  AddressInterleave interleave_;
  unsigned latency_;
  std::vector<LinkReader<Packet>> inputs_;
  WaitingLinks waiting_;  ///< non-empty inputs_
  std::vector<Output> outputs_;
  std::vector<Cycle> due_;  ///< [output] cycle in which its oldest packet may enter the link, or kNever
  IndexSet contended_;      ///< outputs with contenders in this cycle
  IndexSet busy_;           ///< outputs with packets in their buffers
  CrossbarCounters::Network counters_;
  Alarm alarm_;
};

class Crossbar final : public CrossbarModule {
 public:
  using Config = CrossbarConfig;

  /// clock: core domain. Throws Error for an impossible configuration.
  Crossbar(const sc_core::sc_module_name& name, const Config& config, ClockDomain& clock);

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
};

}  // namespace grtx::modules
