// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/kernel/run_ahead.h"

#include <algorithm>
#include <systemc>

#include "grtx/modules/kernel/clock_domain.h"

namespace grtx::modules {

RunAhead::RunAhead(ClockDomain& first, ClockDomain& second, bool enabled)
    : domains_{&first, &second}, enabled_(enabled) {
  for (ClockDomain* domain : domains_) domain->ahead_ = this;
}

RunAhead::~RunAhead() {
  for (ClockDomain* domain : domains_) domain->ahead_ = nullptr;
}

// Called by a domain's process after its tick. Returns whether it has notified the kernel of the next ticks; if false
// the caller must do so.
bool RunAhead::run() {
  const std::uint64_t kernel = sc_core::sc_time_stamp().value();
  if (!enabled_ || until_value_ <= kernel || sc_core::sc_pending_activity_at_current_time()) return false;
  for (ClockDomain* domain : domains_) domain->wake_.cancel();
  running_ = true;
  kernel_value_ = kernel;
  const sc_core::sc_simcontext* const context = sc_core::sc_get_curr_simcontext();
  sc_core::sc_time pending;
  // Checked before each tick: the last one may have created work for the kernel.
  while (!context->pending_activity_at_current_time()) {
    std::uint64_t at = until_value_;
    if (context->next_time(pending)) at = std::min<std::uint64_t>(at, pending.value());
    ClockDomain* earliest = nullptr;
    for (ClockDomain* domain : domains_) {
      if (domain->next_ == kNever || domain->time_value(domain->next_) >= at) continue;
      earliest = domain;
      at = domain->time_value(domain->next_);
    }
    if (earliest == nullptr) break;
    now_value_ = at;
    earliest->step();
  }
  running_ = false;
  for (ClockDomain* domain : domains_) {
    if (domain->next_ != kNever) domain->notify_kernel();
  }
  return true;
}

}  // namespace grtx::modules
