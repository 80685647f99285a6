// SPDX-License-Identifier: Apache-2.0
// A unit between the node port of an RT unit and the L1, e.g. a buffer of nodes. Most machines have none.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <systemc>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

/// Gives each request exactly one response with its tag, in any order: its own, or that of the L1, to which it passes
/// the request on. Counts of what it answers itself: PartInfo::kept_nodes.
class NodePortModule : public ClockedModule {
 public:
  LinkIn<MemoryRequest> request{"request"};      ///< reads of the RT unit
  LinkOut<MemoryResponse> response{"response"};  ///< to the RT unit
  LinkOut<MemoryRequest> to_l1{"to_l1"};
  LinkIn<MemoryResponse> from_l1{"from_l1"};

  /// Nothing inside. Does not consider the links.
  virtual bool idle() const = 0;
  /// Grows whenever the unit makes progress; for a watchdog.
  virtual std::uint64_t progress() const = 0;
  /// Adds its counts to those of the L1.
  virtual void count(OwnCounts& own) const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  using ClockedModule::ClockedModule;
};

}  // namespace grtx::modules
