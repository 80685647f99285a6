// Two clock domains whose ticks follow each other without the SystemC kernel in between.
#pragma once

#include <array>
#include <cstdint>

namespace grtx::modules {

class ClockDomain;

/// As long as the kernel has nothing else to do: a notification, a time step and an activation for each tick were a
/// seventh of all instructions of a run. All ticks still happen in the order of their times, so this is not the
/// temporal decoupling that changes who comes first; merely the kernel's time stays behind, and TLM calls annotate by
/// how much. Not for domains that a foreign DRAM is bound to, which may disregard annotated delays. See allow_ahead().
class RunAhead {
 public:
  /// enabled false leaves every tick to the kernel (for tests).
  RunAhead(ClockDomain& first, ClockDomain& second, bool enabled = true);
  ~RunAhead();
  RunAhead(const RunAhead&) = delete;
  RunAhead& operator=(const RunAhead&) = delete;

 private:
  friend class ClockDomain;

  bool run();

  std::array<ClockDomain*, 2> domains_;
  bool enabled_;
  std::uint64_t until_fs_ = 0;
  std::uint64_t now_fs_ = 0;
  std::uint64_t kernel_fs_ = 0;  ///< the kernel's time, while running
  bool running_ = false;
};

}  // namespace grtx::modules
