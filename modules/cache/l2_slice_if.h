// SPDX-License-Identifier: Apache-2.0
// A slice of the L2 as the GPU sees it: its ports, and how to make one (l2_slice.h).
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <memory>
#include <string>
#include <systemc>
#include <tlm>

#include "grtx/base/state_bytes.h"
#include "grtx/modules/cache/decide/l2_slice_config.h"
#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

/// A slice as the GPU sees it: every request gets exactly one response with its tag, client and SM, in any order.
class L2SliceModule : public ClockedModule {
 public:
  LinkIn<MemoryRequest> request{"request"};
  LinkOut<MemoryResponse> response{"response"};
  /// To the DRAM channel, with global addresses.
  virtual ::tlm::tlm_initiator_socket<32>& memory_socket() = 0;

  virtual L2Counters counters() const = 0;
  /// No request in flight. Dirty sectors may remain in the cache: they are written back only on eviction.
  virtual bool idle() const = 0;
  virtual std::uint64_t dirty_sectors() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;
  /// Until the next restart nothing more is sent to the memory, whose answers are still taken: before a launch that is
  /// under way is abandoned. A slice that ignores it is abandoned once the memory happens to be idle.
  virtual void hold_requests() {}
  /// `refused` hears of each request that the memory answers with an error, with its address on the bus, in place of an
  /// error report; the slice takes it as answered. By default it is never called.
  virtual void on_refusal(const std::function<void(std::uint64_t address, const std::string& what)>& /*refused*/) {}
  /// Makes the sector present as one read before, without traffic and uncounted, in place of a clean line if there is
  /// one. A slice that ignores it is colder than the run it stands for.
  virtual void preload(std::uint64_t /*address*/) {}
  /// Save and restore what restart(Caches::warm) keeps, for a run that another process continues. save() needs an idle
  /// slice, load() a newly constructed one.
  virtual void save(StateWriter& state) const;
  virtual void load(StateReader& state);

 protected:
  using ClockedModule::ClockedModule;
};

/// The project's slice. clock: core domain. Throws Error for an impossible configuration.
std::unique_ptr<L2SliceModule> make_l2_slice(const sc_core::sc_module_name& name, const L2SliceConfig& config,
                                             ClockDomain& clock);

}  // namespace grtx::modules
