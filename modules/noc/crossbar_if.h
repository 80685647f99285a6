// The network between SMs and L2 slices as the GPU sees it.
#pragma once

#include <iosfwd>

#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"

namespace grtx::modules {

struct CrossbarCounters;

/// Requests go to the slice of their address, responses to the SM that they name.
class CrossbarModule : public sc_core::sc_module {
 public:
  sc_core::sc_vector<LinkIn<MemoryRequest>> request_in;      ///< [sm]
  sc_core::sc_vector<LinkOut<MemoryRequest>> request_out;    ///< [slice]
  sc_core::sc_vector<LinkIn<MemoryResponse>> response_in;    ///< [slice]
  sc_core::sc_vector<LinkOut<MemoryResponse>> response_out;  ///< [sm]

  virtual CrossbarCounters counters() const = 0;
  /// No packet inside or waiting at its ports.
  virtual bool idle() const = 0;
  virtual Inventory inventory() const = 0;
  virtual void dump_state(std::ostream& out) const = 0;

 protected:
  CrossbarModule(const sc_core::sc_module_name& name, unsigned sms, unsigned slices)
      : sc_module(name),
        request_in("request_in", sms),
        request_out("request_out", slices),
        response_in("response_in", slices),
        response_out("response_out", sms) {}
};

}  // namespace grtx::modules
