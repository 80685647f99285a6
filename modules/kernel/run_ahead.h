// SPDX-License-Identifier: Apache-2.0
// Lets two clock domains tick in a loop of their own, without returning to the SystemC kernel after each tick.
#pragma once

#include <array>
#include <cstdint>

namespace grtx::modules {

class ClockDomain;

/// The loop runs only while the kernel has nothing else to do; the kernel's work per tick was a seventh of all
/// instructions of a run. Ticks still happen in time order, so unlike temporal decoupling this does not change results:
/// only the kernel's time lags behind, and TLM calls annotate the difference. Not for domains with a foreign DRAM,
/// which may ignore annotated delays. See ClockDomain::allow_ahead().
class RunAhead {
 public:
  /// enabled = false leaves every tick to the kernel (for tests).
  RunAhead(ClockDomain& first, ClockDomain& second, bool enabled = true);
  ~RunAhead();
  RunAhead(const RunAhead&) = delete;
  RunAhead& operator=(const RunAhead&) = delete;

 private:
  friend class ClockDomain;

  bool run();

  std::array<ClockDomain*, 2> domains_;
  bool enabled_;
  // In the kernel's resolution, as sc_time::value().
  std::uint64_t until_value_ = 0;
  std::uint64_t now_value_ = 0;
  std::uint64_t kernel_value_ = 0;  ///< the kernel's time, valid while running_
  bool running_ = false;
};

}  // namespace grtx::modules
