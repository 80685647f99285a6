// SPDX-License-Identifier: Apache-2.0
// Progress of simulations that run in child processes: one bar for all of them, with the share done of each running
// one.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "grtx/base/progress.h"
#include "grtx/base/strong.h"
#include "grtx/modules/simt/work_distributor_if.h"

namespace grtx::experiment {

/// Counts finished warps in memory shared by the parent and its children.
class DesignProgress {
 public:
  /// warps: number of warps of each design.
  DesignProgress(std::vector<std::string> names, std::vector<std::uint64_t> warps, bool quiet);
  ~DesignProgress();
  DesignProgress(const DesignProgress&) = delete;
  DesignProgress& operator=(const DesignProgress&) = delete;

  /// Observer to attach to the simulation of a design, in the child process.
  modules::WarpObserver* observer(std::size_t design) { return &counters_[design]; }
  /// Redraws the bar; the parent calls it from time to time.
  void look();

 private:
  class Counter : public modules::WarpObserver {
   public:
    explicit Counter(std::atomic<std::uint64_t>* ended) : ended_(ended) {}
    void launched(unsigned, unsigned, const traces::RayGroup&, Cycle) override {}
    void ended(unsigned, unsigned, Cycle) override { ended_->fetch_add(1, std::memory_order_relaxed); }

   private:
    std::atomic<std::uint64_t>* ended_;
  };

  const std::vector<std::string> names_;
  const std::vector<std::uint64_t> warps_;
  std::atomic<std::uint64_t>* const shared_;
  std::deque<Counter> counters_;
  Progress progress_;
};

}  // namespace grtx::experiment
