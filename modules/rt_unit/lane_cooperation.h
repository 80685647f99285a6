// Lane cooperation of the RT unit: idle lanes of a warp fetch and test nodes that lie on the stacks of its busy lanes.
// Not part of GRTX; after CoopRT (ISCA 2025), but results are used in the busy ray's own order.
// Cost: a few held results a lane. docs/model/cooperative_lanes.md states the timing.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/rt_unit/cooperation_if.h"
#include "grtx/modules/rt_unit/decide/node_traffic.h"
#include "grtx/modules/rt_unit/decide/stack_contents.h"
#include "grtx/modules/rt_unit/warp_table.h"
#include "grtx/traces/header.h"

namespace grtx::modules {

class LaneCooperation final : public CooperationModule {
 public:
  static constexpr unsigned kMaxAhead = 16;
  struct Config {
    unsigned ahead = 0;  ///< 0: off
    void parameters(ParameterList& list) {
      list.add("ahead", ahead, {0, kMaxAhead}, "nodes",
               "below the top of a busy lane's stack that idle lanes of its warp may fetch and test, and results held "
               "for it; 0: off",
               kOurs)
          .came_later();
    }
  };
  struct Counters {
    std::uint64_t taken = 0, helped = 0, waited = 0, wasted = 0;  ///< each taken is one of the others in the end
    static const CounterTable<Counters>& table();
    void add(const Counters& other) { table().add(*this, other); }
    void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
  };

  /// entries: of the warp buffer. traffic must outlive the unit.
  LaneCooperation(const sc_core::sc_module_name& name, const Config& config, const traces::Header& header,
                  const NodeTraffic& traffic, unsigned entries);

  void begin_lane(LaneId id, const traces::RayGroup& group, std::span<const traces::Event> events) override;
  HelpState claim(LaneId id) override;
  void drop(LaneId id) override;
  std::optional<Help> next(unsigned entry) override;
  bool helps(LaneId id) const override;
  std::optional<LaneId> tested(LaneId helper) override;

  bool idle() const override { return helping_ == 0; }
  std::uint64_t progress() const override { return counters_.taken; }
  void count(RtUnitCounters& all) const override;
  std::uint64_t helping() const { return helping_; }  ///< lanes
  std::uint64_t held() const { return held_; }        ///< results, also those under way
  const Counters& counters() const { return counters_; }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override { counters_ = {}; }

 private:
  /// A node of a lane's stack that another lane has taken.
  struct Result {
    std::uint32_t entry = 0;
    LaneId helper = 0;
    bool there = false;
    bool awaited = false;
  };
  struct Lane {
    StackContents stack;
    std::vector<Result> results;
  };
  struct Job {
    LaneId busy = 0;
    std::uint32_t entry = 0;
  };
  void end_of_elaboration() override;
  std::uint32_t present(LaneId id) const;
  std::vector<Result>::iterator find(Lane& lane, std::uint32_t entry);
  void remove(Lane& lane, std::vector<Result>::iterator result);
  /// The entry of the lane's stack `level` below that of its present event, if it can be taken.
  std::optional<std::uint32_t> candidate(const Warp& warp, LaneId id, unsigned level) const;

  Config config_;
  const NodeTraffic& traffic_;
  unsigned warp_size_;
  unsigned width_;
  WarpTable* table_ = nullptr;
  stack_if* stack_ = nullptr;
  std::vector<Lane> lanes_;
  std::vector<Job> jobs_;  ///< of helping lanes
  std::uint64_t helping_ = 0;
  std::uint64_t held_ = 0;
  Counters counters_;
};

}  // namespace grtx::modules
