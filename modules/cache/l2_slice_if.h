// An L2 slice as the GPU sees it: the crossbar on one side, a TLM-2.0 AT initiator socket towards its memory channel on
// the other.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <tlm>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

struct L2Counters;

/// Every request gets one response with its tag, client and SM, in any order.
class L2SliceModule : public ClockedModule {
 public:
  LinkIn<MemoryRequest> request{"request"};
  LinkOut<MemoryResponse> response{"response"};
  /// Addresses are global.
  virtual ::tlm::tlm_initiator_socket<32>& memory_socket() = 0;

  virtual const L2Counters& counters() const = 0;
  /// Nothing under way. Dirty sectors may remain in the cache: they are written back on eviction only.
  virtual bool idle() const = 0;
  virtual std::uint64_t dirty_sectors() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  using ClockedModule::ClockedModule;
};

}  // namespace grtx::modules
