// SPDX-License-Identifier: Apache-2.0
// Keys and counters of the crossbar.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/address_interleave.h"

namespace grtx::modules {

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

}  // namespace grtx::modules
