// SPDX-License-Identifier: Apache-2.0
// The crossbar as the GPU sees it: its ports, its configuration, its counters, and how to make one (crossbar.h).
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <systemc>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/address_interleave.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

struct CrossbarCounters;

/// The network as the GPU sees it: requests are routed by address to a slice, responses to their `sm`.
class CrossbarModule : public sc_core::sc_module {
 public:
  sc_core::sc_vector<LinkIn<MemoryRequest>> request_in;      ///< [sm]
  sc_core::sc_vector<LinkOut<MemoryRequest>> request_out;    ///< [slice]
  sc_core::sc_vector<LinkIn<MemoryResponse>> response_in;    ///< [slice]
  sc_core::sc_vector<LinkOut<MemoryResponse>> response_out;  ///< [sm]

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
        response_out("response_out", sms) {}
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

struct CrossbarConfig {
  unsigned sms = 8;  ///< set by the assembly
  AddressInterleave interleave{};
  unsigned latency = 8;         ///< cycles from visible at the input to visible at the output
  unsigned output_buffer = 32;  ///< packets per output, in addition to those in transit
  void parameters(ParameterList& list) {
    list.add("latency", latency, {1, kMaxLatency}, "cycles", "of a packet without contention, each way", kOurs);
    list.add("output_buffer", output_buffer, {1, kMaxEntries}, "packets", "waiting at an output", kGpgpuSim);
  }
};

/// The project's crossbar. clock: core domain. Throws Error for an impossible configuration.
std::unique_ptr<CrossbarModule> make_crossbar(const sc_core::sc_module_name& name, const CrossbarConfig& config,
                                              ClockDomain& clock);

}  // namespace grtx::modules
