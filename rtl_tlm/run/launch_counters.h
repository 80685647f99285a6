// SPDX-License-Identifier: Apache-2.0
// The counters of a GPU when some of its warps are launched, read while the run goes on.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "grtx/modules/simt/work_distributor_if.h"
#include "grtx/rtl_tlm/gpu/gpu_counters.h"

namespace grtx::sim {

class LaunchCounters final : public modules::WarpObserver {
 public:
  /// positions: of the launches, each above the one before. observer: is told of all warps, too; nullptr: none. All
  /// must outlive it.
  LaunchCounters(const Gpu& gpu, const MemorySystem& memory, const std::vector<std::uint64_t>& positions,
                 modules::WarpObserver* observer)
      : gpu_(gpu), memory_(memory), positions_(positions), observer_(observer) {}

  void launched(unsigned sm, unsigned slot, const traces::RayGroup& group, Cycle now) override;
  void ended(unsigned sm, unsigned slot, Cycle now) override {
    if (observer_ != nullptr) observer_->ended(sm, slot, now);
  }
  /// By position. Counts of idle cycles lag behind: they are settled when a unit wakes.
  std::vector<GpuCounters> take() { return std::move(counters_); }

 private:
  const Gpu& gpu_;
  const MemorySystem& memory_;
  const std::vector<std::uint64_t>& positions_;
  modules::WarpObserver* observer_;
  std::uint64_t launched_ = 0;
  std::vector<GpuCounters> counters_;
};

}  // namespace grtx::sim
