// SPDX-License-Identifier: Apache-2.0
// The crossbar as the GPU sees it: its ports, and how to make one (crossbar.h).
#pragma once

#include <iosfwd>
#include <memory>
#include <systemc>

#include "grtx/modules/kernel/clocked_module.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_if.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/noc/decide/crossbar_config.h"

namespace grtx::modules {

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

/// The project's crossbar. clock: core domain. Throws Error for an impossible configuration.
std::unique_ptr<CrossbarModule> make_crossbar(const sc_core::sc_module_name& name, const CrossbarConfig& config,
                                              ClockDomain& clock);

}  // namespace grtx::modules
