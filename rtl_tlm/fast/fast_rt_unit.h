// The RT unit in fast mode: the decisions of the cycle model (which warp, which lanes, what is fetched, merged,
// prefetched, checkpointed), but the unit sleeps between the cycles in which one is due, and fetches and intersection
// tests take their times from the resources that they reserve.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "modules/address_index.h"
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
#include "rtl_tlm/fast/fast_l1.h"
#include "rtl_tlm/rt_unit.h"

namespace grtx::tlm {

class FastRtUnit {
 public:
  /// What connects it to the SIMT core and, for checkpoints and prefetches, to the L1.
  struct Links {
    modules::Link<modules::TraceCall>* calls = nullptr;
    modules::Link<modules::TraceDone>* dones = nullptr;
    modules::Link<modules::AnyHitBatch>* batches = nullptr;
    modules::Link<modules::AnyHitDone>* shader_dones = nullptr;
    modules::Link<modules::MemoryRequest>* checkpoint_requests = nullptr;
    modules::Link<modules::MemoryResponse>* checkpoint_responses = nullptr;
    modules::Link<modules::MemoryRequest>* prefetch_requests = nullptr;
    modules::Link<modules::MemoryResponse>* prefetch_responses = nullptr;
  };

  /// name: of the unit, for the parts that are modules. client: number of its node requests at the L1.
  FastRtUnit(const std::string& name, const RtUnitConfig& config, const traces::Header& header,
             const modules::MemoryMap& map, unsigned sm, std::uint8_t client, FastL1& l1, const Links& links);

  /// Asks the L1 for the next node sector, if one is due. Whether the L1 took it.
  bool ask(Cycle now);
  Cycle ask_due() const { return queue_.empty() ? modules::kNever : ask_next_; }
  /// The L1 has room again.
  void wake(Cycle now) { ask_next_ = std::min(ask_next_, now); }
  /// A sector of this fetch has been filled into the L1 in cycle `now`.
  void filled(Cycle now, std::uint32_t fetch);
  /// All that is due in this cycle, but for ask().
  void step(Cycle now);
  /// Next cycle in which step() has something to do.
  Cycle due() const { return due_; }
  /// The SIMT core may have sent something.
  void core_has_run() {
    due_ = std::min(due_, links_.shader_dones->next_visible());
    if (occupied_ != all_) due_ = std::min(due_, links_.calls->next_visible());
  }
  /// The L1 has taken a checkpoint request or a prefetch: the link has room from the next cycle on.
  void client_has_room(Cycle now) {
    if ((checkpoint_ && checkpoint_->busy()) || (prefetcher_ && prefetcher_->busy())) due_ = std::min(due_, now + 1);
  }
  /// A response that the unit waits for is seen in this cycle.
  void response_arrives(Cycle cycle) { due_ = std::min(due_, cycle); }
  bool idle() const;
  /// Closes per-cycle counts at `end`.
  void settle(Cycle end);
  RtUnitCounters counters() const;

 private:
  struct Fetch {
    std::uint64_t address = 0;
    LaneMask lanes = 0;
    Cycle asked = 0;
    Cycle ready = 0;  ///< when the sectors that are back were seen
    traces::NodeKind kind = traces::NodeKind::internal;
    bool header = false;
    std::uint8_t sectors = 0;
    std::uint8_t sent = 0;
    std::uint8_t missing = 0;
  };
  struct Due {
    Cycle cycle = 0;
    modules::LaneId lane = 0;
  };
  /// Ascending; insertion from the end.
  static void insert(modules::RingQueue<Due>& queue, Due due);

  struct Unit {
    explicit Unit(const modules::IntersectionUnit::Config& c) : config(c), free_from(c.count) {}
    modules::IntersectionUnit::Config config;
    std::vector<Cycle> free_from;
    modules::RingQueue<Due> flights;
    modules::IntersectionUnit::Counters counters;
    void enqueue(Cycle now, modules::LaneId lane, unsigned tests);
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
  void arrive(const Fetch& fetch, modules::LaneId id);
  Cycle next_due(Cycle now) const;
  void take_fetch(Cycle now, modules::LaneId id);
  void unit_result(Cycle now, modules::LaneId id);
  void complete(Cycle now, modules::LaneId id, unsigned checkpoints, modules::LaneState from);
  void schedule(Cycle now);
  void visit(Cycle now, modules::LaneId id, const traces::Event& event);
  void fetch(Cycle now, modules::LaneId id, traces::NodeKind kind, std::uint64_t address, bool header);
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
  std::uint8_t client_;
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
  std::vector<Fetch> fetches_;  ///< by the lane that asked first
  std::vector<modules::AddressIndex> merge_;
  std::vector<std::uint64_t> visited_;  ///< without merging in flight: keys of the present warp's visits
  unsigned visited_entry_ = 0;
  modules::RingQueue<modules::LaneId> queue_;  ///< fetches with sectors to ask for
  modules::RingQueue<Due> arrived_;            ///< fetches that are complete
  Cycle ask_next_ = 0;
  Cycle fill_free_ = 0;  ///< of the port on which filled sectors return

  Unit box_, leaf_, transform_;
  Cycle due_ = modules::kNever;
  Cycle accounted_ = 0;
  modules::WarpBuffer::Counters buffer_counters_;
  modules::RtScheduler::Counters scheduler_counters_;
  modules::MemoryScheduler::Counters memory_counters_;
  modules::AnyHitCollector::Counters any_hit_counters_;
};

}  // namespace grtx::tlm
