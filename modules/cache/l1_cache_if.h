// An L1 data cache as an SM sees it: client ports on one side, one port to the memory on the other.
#pragma once

#include <iosfwd>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

struct L1Counters;

/// Every request gets one response with its tag, in any order. A cache that has no use for our clock ignores it.
class L1CacheModule : public ClockedModule {
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

 protected:
  L1CacheModule(const sc_core::sc_module_name& name, ClockDomain& clock, unsigned clients)
      : ClockedModule(name, clock), request("request", clients), response("response", clients) {}
};

}  // namespace grtx::modules
