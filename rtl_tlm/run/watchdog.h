// SPDX-License-Identifier: Apache-2.0
// Detects a deadlock: work remains, but nothing moves and nothing is scheduled for a later time. Work scheduled for
// later (an access of a slow memory, a long phase of a shader) is waited for, however long.
#pragma once

#include <cstdint>
#include <string>

#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"

namespace grtx::sim {

class Watchdog {
 public:
  /// limit: cycles without progress. step: cycles between two calls of deadlock(). Both models must outlive it.
  Watchdog(const Gpu& gpu, const MemorySystem& memory, Cycle limit, Cycle step)
      : gpu_(gpu), memory_(memory), limit_(limit), step_(step) {}

  /// Why the model is deadlocked; empty: it is not. Throws Error when simulated time exceeds what the kernel can count.
  std::string deadlock();

 private:
  const Gpu& gpu_;
  const MemorySystem& memory_;
  Cycle limit_, step_;
  std::uint64_t progress_ = ~std::uint64_t{0};
  Cycle since_ = 0;
};

}  // namespace grtx::sim
