// The work distributor in fast mode: which group goes to which SM, one launch a cycle.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "grtx/modules/simt/work_distributor.h"
#include "grtx/rtl_tlm/estimate/fast/shared.h"

namespace grtx::sim::fast {

class Distributor {
 public:
  /// launch(cycle, SM, slot, group): the warp comes to the SM in that cycle.
  using Launch = std::function<void(Cycle, unsigned, unsigned, const traces::RayGroup&)>;

  Distributor(const Shared& shared, modules::GroupSource& source, Launch launch);

  void observe(modules::WarpObserver* observer) { observer_ = observer; }
  void assign(std::vector<unsigned> sms) { assigned_ = std::move(sms); }
  void report(std::function<void(std::uint64_t)> progress) { progress_ = std::move(progress); }

  /// All that can be launched now.
  void launch(Cycle now);
  /// The warp has done its stores.
  void ended(Cycle now, unsigned sm, unsigned slot);
  /// The run is over. Throws std::runtime_error when it cannot be.
  void finish(Cycle now);

  bool idle() const { return running_ == 0; }
  Cycle end() const { return end_; }  ///< when the last warp had ended
  /// As the cycle model counts; a cycle here is `stride` of a run in which all events take time.
  modules::DistributorCounters counters() const;

 private:
  struct Sm {
    LaneMask free_slots = 0;
    std::uint64_t launched = 0;
    std::vector<std::uint64_t> position;  ///< by slot: of the group in the source
  };
  bool held_back(Cycle now);
  Cycle whole(Cycle cycle) const { return cycle * shared_.stride; }

  const Shared& shared_;
  modules::GroupSource& source_;
  Launch launch_;
  modules::WarpObserver* observer_ = nullptr;
  std::function<void(std::uint64_t)> progress_;
  std::vector<unsigned> assigned_;  ///< SMs of the first groups
  std::vector<Sm> sms_;
  std::uint64_t next_group_ = 0, running_ = 0, ended_ = 0;
  const traces::RayGroup* acquired_ = nullptr;  ///< and not launched yet
  modules::LaunchOrder order_;
  unsigned turn_ = 0;  ///< SM that is looked at first
  Cycle last_launch_ = 0;
  Cycle end_ = 0;
};

}  // namespace grtx::sim::fast
