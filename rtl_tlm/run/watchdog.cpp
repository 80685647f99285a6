// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/run/watchdog.h"

#include <fmt/format.h>

#include <algorithm>
#include <systemc>

#include "grtx/base/error.h"

namespace grtx::sim {
namespace {

/// Throws Error before the kernel's time, 64 bits, can wrap around in what is scheduled.
void check_time(const Gpu& gpu, Cycle now) {
  constexpr std::uint64_t kLast = std::uint64_t{1} << 63;
  if (gpu.core().time_value(now) < kLast && now < kLast / gpu.core().period_value()) return;
  throw Error("sim", "",
              fmt::format("{} cycles are {:.0f} s of the machine's time: more than a run can take", now,
                          sc_core::sc_time::from_value(kLast).to_seconds()));
}

}  // namespace

std::string Watchdog::deadlock() {
  const std::uint64_t progress = gpu_.progress() + memory_.progress();
  const Cycle now = gpu_.core().edge_at_or_after_now();
  check_time(gpu_, now);
  if (progress != progress_) {
    progress_ = progress;
    since_ = now;
  }
  const Cycle awaited = std::max(gpu_.awaited(), gpu_.core().cycle_at(memory_.awaited_fs()));
  if (awaited > now + step_) since_ = std::max(since_, awaited);  // polling only schedules cycles that come soon
  if (!sc_core::sc_pending_activity()) return "nothing is scheduled";
  if (now > since_ + limit_) return fmt::format("no progress for {} cycles", now - since_);
  return "";
}

}  // namespace grtx::sim
