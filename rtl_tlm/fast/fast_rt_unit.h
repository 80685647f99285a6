// The RT unit in fast mode: the decisions of the cycle model (which warp, which lanes, what is fetched, merged,
// prefetched, checkpointed), but a visit is one event: when the lane starts it, the times of its fetch and of its
// intersection tests follow from the resources that they reserve.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "modules/checkpoint_unit.h"
#include "modules/link.h"
#include "modules/memory_map.h"
#include "modules/node_traffic.h"
#include "modules/ring_queue.h"
#include "modules/round_cursor.h"
#include "modules/sibling_prefetcher.h"
#include "modules/warp_buffer.h"
#include "modules/warp_messages.h"
#include "modules/warp_selection.h"
#include "rtl_tlm/fast/due_wheel.h"
#include "rtl_tlm/fast/fast_l1.h"
#include "rtl_tlm/fast/port_calendar.h"
#include "rtl_tlm/fast/slot_calendar.h"
#include "rtl_tlm/rt_unit.h"

namespace grtx::tlm {

class FastRtUnit {
 public:
  /// What connects it to the SIMT core and, for checkpoints, to the L1.
  struct Links {
    modules::Link<modules::TraceCall>* calls = nullptr;
    modules::Link<modules::TraceDone>* dones = nullptr;
    modules::Link<modules::AnyHitBatch>* batches = nullptr;
    modules::Link<modules::AnyHitDone>* shader_dones = nullptr;
    modules::Link<modules::MemoryRequest>* checkpoint_requests = nullptr;
    modules::Link<modules::MemoryResponse>* checkpoint_responses = nullptr;
  };

  /// name: of the unit, for the parts that are modules.
  FastRtUnit(const std::string& name, const RtUnitConfig& config, const traces::Header& header,
             const modules::MemoryMap& map, unsigned sm, FastL1& l1, const Links& links);

  /// All that is due in this cycle.
  void step(Cycle now);
  /// Nothing will be asked before cycle `now` any more.
  void advance(Cycle now) {
    for (Unit* unit : {&box_, &leaf_, &transform_}) unit->places.advance(now);
    responses_.advance(now);
  }
  /// Next cycle in which step() has something to do.
  Cycle due() const { return due_; }
  /// The SIMT core may have sent something.
  void core_has_run() {
    due_ = std::min(due_, links_.shader_dones->next_visible());
    if (occupied_ != all_) due_ = std::min(due_, links_.calls->next_visible());
  }
  /// The L1 has taken a checkpoint request: the link has room from the next cycle on.
  void client_has_room(Cycle now) {
    if (checkpoint_ && checkpoint_->busy()) due_ = std::min(due_, now + 1);
  }
  /// A response that the unit waits for is seen in this cycle.
  void response_arrives(Cycle cycle) { due_ = std::min(due_, cycle); }
  bool idle() const;
  /// Closes per-cycle counts at `end`.
  void settle(Cycle end);
  RtUnitCounters counters() const;

 private:
  /// A node on its way to a warp, or there already.
  struct Fetch {
    std::uint64_t key = ~std::uint64_t{0};
    Cycle asked = 0;
    Cycle ready = 0;     ///< all its sectors have been seen; kNever while it waits for its turn at the L1
    LaneMask lanes = 0;  ///< that wait with it for its turn
  };
  /// The fetches of a warp by node. At most one a lane waits; what has arrived is overwritten.
  static constexpr std::size_t kPlaces = 2 * modules::kMaxLanes;
  static constexpr std::size_t kProbes = 4;
  using FetchTable = std::array<Fetch, kPlaces>;
  /// A fetch that waits for its turn.
  struct Waiting {
    std::uint64_t address = 0;
    Cycle seen = 0;            ///< the sectors asked for so far
    modules::LaneId lane = 0;  ///< that asked first
    std::uint8_t place = 0;    ///< in its warp's table
    traces::NodeKind kind = traces::NodeKind::internal;
    bool header = false;
    std::uint8_t left = 0;  ///< sectors to ask for
  };

  /// A port at the L1. Asks some cycles ahead of time, but not what has been refused.
  struct Port {
    static constexpr Cycle kAhead = 8;
    Cycle next = 1;  ///< cycle of the next request
    bool refused = false;
    bool may(Cycle now) const { return next <= now + (refused ? 0 : kAhead); }
    Cycle due() const { return refused ? next : next - 1; }
    /// Whether the request was taken.
    bool answered(const FastL1::Access& access) {
      refused = access.taken == modules::kNever;
      next = refused ? access.seen : access.taken + 1;
      return !refused;
    }
  };

  struct Unit {
    explicit Unit(const modules::IntersectionUnit::Config& c) : config(c), places(c.count, c.interval) {}
    modules::IntersectionUnit::Config config;
    SlotCalendar places;
    modules::IntersectionUnit::Counters counters;
    /// When the result of tests on data that is there from cycle `ready` on is known.
    Cycle test(Cycle ready, unsigned tests);
  };
  struct Times {
    Cycle since = 0;  ///< first cycle whose wait has not been counted
    modules::WarpWait wait = modules::WarpWait::ready;
  };

  modules::Lane& lane(modules::LaneId id) { return warps_[modules::entry_of(id)].lane[modules::lane_of(id)]; }
  void move(Cycle now, unsigned entry, LaneMask lanes, modules::LaneState from, modules::LaneState to);
  void count_wait(Cycle end, unsigned entry);
  modules::Stall stall_reason() const;
  void refresh_waits();
  Cycle next_due(Cycle now) const;
  void prefetch_host() const;
  void unit_result(Cycle now, modules::LaneId id);
  void complete(Cycle now, modules::LaneId id, unsigned checkpoints, modules::LaneState from);
  void schedule(Cycle now);
  void visit(Cycle now, modules::LaneId id, const traces::Event& event);
  void fetch(Cycle now, modules::LaneId id, traces::NodeKind kind, std::uint64_t address, bool header);
  void ask(Cycle now);
  unsigned sectors_of(traces::NodeKind kind, bool header) const;
  modules::MemoryRequest next_sector(const Waiting& fetch) const;
  void await_result(Cycle now, modules::LaneId id, traces::NodeKind kind, Cycle ready);
  void replay(Cycle now, modules::LaneId id, modules::LaneState from);
  void pop(modules::LaneId id);
  void any_hit_arrives(Cycle now, modules::LaneId id);
  void any_hit_returns(Cycle now);
  void fire(Cycle now);
  Cycle any_hit_due(const modules::Warp& warp) const;
  void retire(Cycle now);
  void accept(Cycle now);
  unsigned oldest(LaneMask entries) const { return modules::OldestFirst::oldest(entries, ages_); }
  bool has_room() const { return queue_.size() + modules::kMaxLanes <= config_.memory.queue; }
  [[noreturn]] void refuse(modules::LaneId id, const char* rule) const;

  RtUnitConfig config_;
  FastL1& l1_;
  Links links_;
  modules::NodeTraffic traffic_;
  std::unique_ptr<modules::CheckpointUnit> checkpoint_;
  std::unique_ptr<modules::SiblingPrefetcher> prefetcher_;
  std::unique_ptr<modules::WarpSelection> selection_;

  // Warp buffer.
  std::vector<modules::Warp> warps_;
  std::vector<std::uint64_t> ages_;
  std::vector<Times> times_;
  std::vector<modules::RoundCursor> cursors_;  ///< by resident slot
  LaneMask all_ = 0, occupied_ = 0, ready_ = 0, done_ = 0;
  LaneMask touched_ = 0;     ///< entries whose state changed in this step
  LaneMask candidates_ = 0;  ///< entries with lanes for the any-hit shader and none there
  std::uint64_t next_age_ = 0;

  // Node fetches.
  std::vector<FetchTable> fetches_;  ///< by entry
  modules::RingQueue<Waiting> queue_;
  Port ask_;  ///< of node requests
  Port prefetch_;
  modules::MemoryRequest prefetched_;  ///< the prefetcher's last one
  bool prefetching_ = false;           ///< which the L1 refused
  PortCalendar responses_;             ///< of the L1 to node requests
  std::vector<Cycle> hits_;            ///< when those left the L1 that fill its pipeline, the oldest first
  std::size_t next_hit_ = 0;
  DueWheel results_;  ///< lanes in the cycle in which their node has been tested

  Unit box_, leaf_, transform_;
  Cycle due_ = modules::kNever;
  Cycle accounted_ = 0;
  modules::WarpBuffer::Counters buffer_counters_;
  modules::RtScheduler::Counters scheduler_counters_;
  modules::MemoryScheduler::Counters memory_counters_;
  modules::AnyHitCollector::Counters any_hit_counters_;
};

}  // namespace grtx::tlm
