// SPDX-License-Identifier: Apache-2.0
// The L1 data cache as an SM sees it: its ports, and how to make one (l1_cache.h).
#pragma once

#include <iosfwd>
#include <memory>
#include <systemc>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/cache/decide/l1_cache_config.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/messages/read_at_once_if.h"

namespace grtx::modules {

/// An L1 as the SM sees it: every request gets exactly one response with its tag, in any order. An implementation that
/// needs no clock may ignore it.
class L1CacheModule : public ClockedModule, public read_at_once_if {
 public:
  sc_core::sc_vector<LinkIn<MemoryRequest>> request;     ///< [client], consumed here
  sc_core::sc_vector<LinkOut<MemoryResponse>> response;  ///< [client], produced here
  LinkOut<MemoryRequest> to_memory{"to_memory"};         ///< misses and writes, with client and SM filled in
  LinkIn<MemoryResponse> from_memory{"from_memory"};     ///< fills and write acknowledgements

  /// Counts so far.
  virtual L1Counters counters() const = 0;
  /// Nothing inside and nothing waiting at its ports.
  virtual bool idle() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;
  /// Makes the sector present as one read before, without traffic and uncounted, in place of a clean line if there is
  /// one. A cache that ignores it is colder than the run it stands for.
  virtual void preload(std::uint64_t /*address*/) {}
  /// Save and restore what restart(Caches::warm) keeps, for a run that another process continues. save() needs an idle
  /// cache, load() a newly constructed one.
  virtual void save(StateWriter& state) const;
  virtual void load(StateReader& state);
  /// Needed where rt.memory.l1_hit_latency is set; refuses unless overridden.
  ReadAtOnce read_at_once(Cycle now, const MemoryRequest& sector) override;

 protected:
  L1CacheModule(const char* name, ClockDomain& clock, unsigned clients) = delete;  ///< see ClockedModule
  L1CacheModule(const sc_core::sc_module_name& name, ClockDomain& clock, unsigned clients)
      : ClockedModule(name, clock), request("request", clients), response("response", clients) {}
};

/// The project's L1. clock: core domain. Throws Error for an impossible configuration.
std::unique_ptr<L1CacheModule> make_l1_cache(const sc_core::sc_module_name& name, const L1CacheConfig& config,
                                             ClockDomain& clock);

}  // namespace grtx::modules
