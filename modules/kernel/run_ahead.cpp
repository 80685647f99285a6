#include "grtx/modules/kernel/run_ahead.h"

#include <algorithm>
#include <systemc>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/kernel/clock_threads.h"

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
  if (!enabled_ || until_fs_ <= kernel || sc_core::sc_pending_activity_at_current_time()) return false;
  for (ClockDomain* domain : domains_) domain->wake_.cancel();
  running_ = true;
  kernel_fs_ = kernel;
  const sc_core::sc_simcontext* const context = sc_core::sc_get_curr_simcontext();
  sc_core::sc_time pending;
  // Checked before each tick: the last one may have created work for the kernel.
  while (!context->pending_activity_at_current_time()) {
    std::uint64_t at = until_fs_;
    if (context->next_time(pending)) at = std::min<std::uint64_t>(at, pending.value());
    ClockDomain* earliest = nullptr;
    bool unsure = false;  // other threads may still send something to the earliest domain
    for (ClockDomain* domain : domains_) {
      const Cycle sure = domain->threads_ != nullptr ? domain->threads_->sure(domain->next_) : kNever;
      const Cycle next = std::min(domain->next_, sure);
      if (next == kNever || domain->time_fs(next) >= at) continue;
      earliest = domain;
      at = domain->time_fs(next);
      unsure = next == sure;
    }
    if (earliest == nullptr) break;
    if (unsure) {
      earliest->threads_->wait();
      continue;
    }
    now_fs_ = at;
    earliest->step();
  }
  running_ = false;
  for (ClockDomain* domain : domains_) {
    if (domain->threads_ != nullptr) domain->stay_awake();
    if (domain->next_ != kNever) domain->notify_kernel();
  }
  return true;
}

}  // namespace grtx::modules
