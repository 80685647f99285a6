// Progress of simulations that run in child processes: a bar over all of them, with the share of each that is under
// way.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "grtx/base/progress.h"
#include "grtx/base/strong.h"
#include "grtx/modules/simt/work_distributor.h"

namespace grtx::sim {

/// Counts ends of warps in memory that parent and children share.
class DesignProgress {
 public:
  /// warps: how many each design has.
  DesignProgress(std::vector<std::string> names, std::vector<std::uint64_t> warps, bool quiet);
  ~DesignProgress();
  DesignProgress(const DesignProgress&) = delete;
  DesignProgress& operator=(const DesignProgress&) = delete;

  /// For the simulation of a design, in its child.
  modules::WarpObserver* observer(std::size_t design) { return &counters_[design]; }
  /// In the parent, now and then.
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

}  // namespace grtx::sim
