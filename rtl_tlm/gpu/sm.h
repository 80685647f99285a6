// SPDX-License-Identifier: Apache-2.0
// Streaming multiprocessor: SIMT core, RT units and L1 data cache, and the links between them. Paper: Table I and the
// figure of the architecture (one RT unit per SM, behind the SM's L1). Cost: the sum of its parts.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/cache/l1_cache_if.h"
#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/rt_unit/rt_unit_if.h"
#include "grtx/modules/simt/simt_core_if.h"
#include "grtx/rtl_tlm/gpu/gpu_parts.h"
#include "grtx/traces/header.h"

namespace grtx::sim {

/// Registered links inside an SM. Capacity 2 sustains one message per cycle at latency 1; the queues of messages
/// between SIMT core and RT unit hold one per resident warp and never block.
struct SmLinks {
  unsigned message_latency = 1;  ///< SIMT core <-> RT unit, cycles
  unsigned l1_latency = 1;       ///< to the L1 and back, cycles; the way back is part of the L1's hit latency
  unsigned l1_capacity = 4;      ///< requests waiting at a port of the L1
  void message_parameters(modules::ParameterList& list) {
    list.add("message_latency", message_latency, {1, modules::kMaxLatency}, "cycles",
             "of messages between SIMT core and RT unit", modules::kOurs);
  }
  void l1_parameters(modules::ParameterList& list) {
    list.add("link_latency", l1_latency, {1, modules::kMaxLatency}, "cycles",
             "of the links to and from the L1; the way back is part of l1.latency", modules::kOurs);
    list.add("link_capacity", l1_capacity, {1, modules::kMaxEntries}, "requests", "waiting at a port of the L1",
             modules::kOurs);
  }
};

struct SmConfig {
  unsigned index = 0;
  unsigned rt_units = 1;
  unsigned resident_warps = 32;
  modules::SimtCoreConfig simt;  ///< Sm sets sm, resident_warps and l1_client
  modules::RtUnitConfig rt;
  modules::L1CacheConfig l1;  ///< Sm sets sm, clients and widths
  SmLinks links;
  modules::OwnKeys own;  ///< keys of units that not every machine has
};

class Sm final : public sc_core::sc_module {
 public:
  /// header, map and clock must outlive the SM. order: see construct().
  Sm(const sc_core::sc_module_name& name, const SmConfig& config, const traces::Header& header,
     const modules::MemoryMap& map, modules::ClockDomain& clock, std::uint64_t order, const SmParts& parts = {});

  // To the rest of the GPU.
  modules::LinkIn<modules::LaunchWarp> launch{"launch"};
  modules::LinkOut<modules::WarpEnded> ended{"ended"};
  modules::LinkOut<modules::MemoryRequest> to_memory{"to_memory"};
  modules::LinkIn<modules::MemoryResponse> from_memory{"from_memory"};

  const modules::SimtCoreModule& simt() const { return *simt_; }
  const std::vector<std::unique_ptr<modules::RtUnitModule>>& rt_units() const { return rt_; }
  const modules::L1CacheModule& l1() const { return *l1_; }
  modules::L1CacheModule& l1() { return *l1_; }
  /// Counts of the L1; `own` has, by name, those of a user-supplied one and of units at the node ports.
  modules::L1Counters l1_counters() const;

  /// Calls f(link) for each link inside the SM, whatever it carries.
  template <typename F>
  void for_each_link(F&& f) const {
    for (const RtLinks& links : rt_links_) {
      f(*links.trace_call);
      f(*links.trace_done);
      f(*links.any_hit_batch);
      f(*links.any_hit_done);
      if (links.node_fetch) f(*links.node_fetch);
      if (links.node_fetch_done) f(*links.node_fetch_done);
    }
    for (const auto& request : requests_) f(*request);
    for (const auto& response : responses_) f(*response);
    for (const auto& request : node_requests_) f(*request);
    for (const auto& response : node_responses_) f(*response);
  }
  /// True if nothing is inside, links included.
  bool idle() const;
  /// Grows whenever the SM does anything; for a watchdog.
  std::uint64_t progress() const;
  std::vector<modules::Inventory> inventory() const;
  void dump_state(std::ostream& out) const;

 private:
  template <typename T>
  using LinkPointer = std::unique_ptr<modules::Link<T>>;

  /// Ports of the L1; ports that the configuration does not use are not built.
  struct L1Clients {
    std::vector<std::string> names;
    std::vector<unsigned> widths;  ///< sectors per cycle
    std::uint8_t simt = 0;         ///< number of the SIMT core's port
  };
  static L1Clients l1_clients(const SmConfig& config, const traces::Header& header);
  void make_rt_links(const SmConfig& config);
  void make_l1_links(const SmConfig& config, const L1Clients& clients);
  /// clients: names of the L1's ports.
  void bind_rt_unit(unsigned unit, const std::vector<std::string>& clients);
  void bind_node_port(unsigned unit, const modules::RtUnitModule::L1Port& port, std::size_t client);

  /// Between the SIMT core and one RT unit; the last two exist when the shader cores fetch the nodes.
  struct RtLinks {
    LinkPointer<modules::TraceCall> trace_call;
    LinkPointer<modules::TraceDone> trace_done;
    LinkPointer<modules::AnyHitBatch> any_hit_batch;
    LinkPointer<modules::AnyHitDone> any_hit_done;
    LinkPointer<modules::NodeFetchBatch> node_fetch;
    LinkPointer<modules::NodeFetchDone> node_fetch_done;
  };

  bool at_once_;                   ///< the L1 is asked for nodes in the cycle of the request
  std::vector<RtLinks> rt_links_;  ///< by RT unit
  std::vector<LinkPointer<modules::MemoryRequest>> requests_;         ///< by client of the L1
  std::vector<LinkPointer<modules::MemoryResponse>> responses_;       ///< by client of the L1
  std::vector<LinkPointer<modules::MemoryRequest>> node_requests_;    ///< to units at the node ports, by RT unit
  std::vector<LinkPointer<modules::MemoryResponse>> node_responses_;  ///< from units at the node ports, by RT unit
  std::unique_ptr<modules::SimtCoreModule> simt_;
  std::vector<std::unique_ptr<modules::RtUnitModule>> rt_;
  std::vector<std::unique_ptr<modules::NodePortModule>> node_ports_;  ///< by RT unit; empty: none
  std::unique_ptr<modules::L1CacheModule> l1_;
};

}  // namespace grtx::sim
