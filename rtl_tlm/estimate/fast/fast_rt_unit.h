// The RT unit of an SM in fast mode: the calls in its warp buffer, the order of warps, and what becomes of a lane's
// events.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/round_cursor.h"
#include "grtx/modules/rt_unit/decide/event_effect.h"
#include "grtx/modules/rt_unit/decide/node_visit.h"
#include "grtx/modules/rt_unit/rt_unit.h"
#include "grtx/rtl_tlm/estimate/fast/fast_checkpoints.h"
#include "grtx/rtl_tlm/estimate/fast/fast_l1.h"
#include "grtx/rtl_tlm/estimate/fast/fast_prefetcher.h"
#include "grtx/rtl_tlm/estimate/fast/fast_stacks.h"
#include "grtx/rtl_tlm/estimate/fast/intersection_pipelines.h"
#include "grtx/rtl_tlm/estimate/fast/node_fetches.h"

namespace grtx::sim::fast {

class Simt;

class RtUnit {
 public:
  RtUnit(Shared& shared, unsigned sm, L1& l1, Simt& simt);
  RtUnit(const RtUnit&) = delete;

  /// A traceRay call; `lanes` are those that have the round.
  void call(Cycle now, const modules::TraceCall& call);
  /// The any-hit shader has served these lanes of the warp in an entry; the RT unit sees it in cycle `seen`.
  void any_hit_done(Cycle seen, unsigned entry, LaneMask lanes);

  // ---- Events
  void lane_event(Cycle now, modules::LaneId id);
  void select(Cycle now);
  void any_hit_due(Cycle now, unsigned entry);
  /// One more of the lane's events that take no time is seen by the caches.
  void touch(Cycle now, modules::LaneId id);
  void advance(Cycle now);

  // ---- The L1
  /// The requests of a fetch will have been seen in cycle `seen`. pushed: when the last of them entered the link.
  void node_arrives(std::uint32_t leader, Cycle seen, bool last, Cycle pushed);
  Checkpoints& checkpoints() { return checkpoints_; }
  Stacks& stacks() { return *stacks_; }
  /// Requests have left: another warp may fit now.
  void room_may_have_come(Cycle now) {
    if (ready_ != 0) select_soon(now);
  }

  bool idle() const { return occupied_ == 0 && waiting_calls_.empty(); }
  /// Counts the cycles before `end` without a selection, by what the oldest warp waits for.
  void count_stall(Cycle end);
  modules::RtUnitCounters counters() const;

 private:
  struct Lane {
    const traces::Event* next = nullptr;
    const traces::Event* end = nullptr;
    std::uint16_t depth = 0;       ///< of the stack
    bool shaded = false;           ///< the any-hit shader has seen its hit
    bool stacking = false;         ///< its stack spills or fills
    std::uint8_t checkpoints = 0;  ///< entries of the event that has ended
    bool settling = false;         ///< hands checkpoint entries over
    std::uint16_t owed = 0;        ///< events that take no time, before those of its next step
    bool begins = false;           ///< its first event that takes time is next
    bool touching = false;         ///< on the agenda to touch
    // Events that take no time meet the caches one after the other while the one before them takes time.
    const traces::Event* touched = nullptr;    ///< the first that the caches have not seen
    const traces::Event* touch_end = nullptr;  ///< the next that takes time, as far as is known
    Cycle started = 0;                         ///< its last event that took time
    Cycle pace = 1;                            ///< between two touches
  };
  /// A traceRay call of a warp, in an entry of the warp buffer.
  struct Call {
    const traces::RayGroup* group = nullptr;
    std::uint32_t round = 0;
    std::uint16_t slot = 0;
    modules::WarpWait wait = modules::WarpWait::ready;
    bool timing = false;  ///< the any-hit timer is on the agenda
    LaneMask active = 0;  ///< not finished
    LaneMask ready = 0, waiting_any_hit = 0, in_any_hit = 0, checkpointing = 0,
             stacking = 0;  ///< of these; the others' nodes are on the way
    Cycle accepted = 0;
    Cycle selected = 0;       ///< last
    Cycle since = 0;          ///< first cycle whose wait has not been counted
    Cycle any_hit_since = 0;  ///< of the first lane that waits
    NodeFetches fetches;
  };
  using LaneId = modules::LaneId;

  Call& call_of(LaneId id) { return calls_[modules::entry_of(id)]; }
  static LaneMask lane_bit(LaneId id) { return modules::bit(modules::lane_of(id)); }
  [[noreturn]] void refuse(LaneId id, const char* rule) const;

  void accept(Cycle now);
  void begin(Call& call, unsigned entry, const modules::TraceCall& message);
  void retire(Cycle now, unsigned entry);
  void count_wait(Cycle now, Call& call);
  void make_ready(Cycle now, LaneId id, Call& call);
  /// From when on the memory scheduler's queue has room for any warp's visits; kNever: that is not known yet.
  Cycle room_from(Cycle now);
  void select_soon(Cycle now);
  void handle(Cycle now, LaneId id, Lane& lane, Call& call);
  void replay(Cycle now, LaneId id, Lane& lane, Call& call);
  /// Whether the lane's next event takes the top of its stack.
  static bool takes_top(const Lane& lane) {
    return lane.next != lane.end && modules::EventEffect(*lane.next).takes_top();
  }
  /// What the lane's event does to its stack.
  void move_stack(LaneId id, Lane& lane, const modules::EventEffect& effect) {
    if (!effect.move_stack(lane.depth)) refuse(id, modules::kRuleNodeOnStack);
    std::uint64_t& deepest = counters_.warp_buffer.max_stack_depth;
    if (effect.pushed() != 0) deepest = std::max<std::uint64_t>(deepest, lane.depth);
  }
  void complete(Cycle now, LaneId id, Lane& lane, const modules::EventEffect& effect, Call& call);
  /// The lane's event has done all but move stack entries and write its checkpoint entries.
  void end_event(Cycle now, LaneId id, Lane& lane, unsigned checkpoints, Call& call);
  void hand_over(Cycle now, LaneId id, Lane& lane, unsigned checkpoints, Call& call);
  void settled(Cycle now, LaneId id, Lane& lane, Call& call);
  void any_hit_arrives(Cycle now, LaneId id, Call& call);
  void consider_any_hit(Cycle now, unsigned entry);
  void fire(Cycle now, unsigned entry);

  // ---- Node fetches (fast_fetch.cpp)
  /// Counts the event, which visits a node, and refuses one that is not there.
  modules::NodeVisit visit(LaneId id, const traces::Event& event, const Call& call);
  void fetch(Cycle now, LaneId id, Lane& lane, Call& call, const modules::NodeVisit& node);
  /// The node is there in cycle `ready`.
  void await(LaneId id, const Lane& lane, const Call& call, Cycle ready);

  // ---- Events that take no time (fast_warming.cpp)
  /// The lane's next `count` events, or those that are left, happen at once: caches, buffers and counts of the trace
  /// see them.
  void warm(LaneId id, Lane& lane, Call& call, unsigned count);
  void warm_visit(LaneId id, Lane& lane, Call& call, const traces::Event& event);
  /// What the caches and the prefetcher see of the lane's first event that they have not seen.
  void touch_next(LaneId id, Lane& lane, const Call& call);
  /// The lane's event begins to take time: those behind it will be touched meanwhile.
  void start_touches(Cycle now, LaneId id, Lane& lane, const Call& call);
  /// The lane's events up to the next that takes time. Returns whether there is one. apart: cycles since the warp was
  /// selected last.
  bool warm_up_to_next(Cycle now, LaneId id, Lane& lane, Call& call, Cycle apart);
  /// Whether the event visits a node that its warp is fetching, and will be in cycle `then`.
  bool is_under_way(const traces::Event& event, const Call& call, Cycle now, Cycle then) const;

  Shared& shared_;
  const modules::RtUnitConfig& config_;
  unsigned sm_;
  L1& l1_;
  Simt& simt_;
  Checkpoints checkpoints_;
  std::optional<Prefetcher> prefetcher_;
  std::optional<Stacks> stacks_;
  std::vector<Lane> lanes_;
  std::vector<Call> calls_;
  std::vector<std::uint64_t> ages_;            ///< by entry
  std::vector<modules::RoundCursor> cursors_;  ///< by resident slot
  modules::RingQueue<modules::TraceCall> waiting_calls_;
  LaneMask free_entries_ = 0;
  LaneMask occupied_ = 0;
  unsigned oldest_ = 0;  ///< of the occupied entries
  LaneMask ready_ = 0;   ///< entries with lanes to be handled
  std::uint64_t next_age_ = 0;
  bool select_timed_ = false;
  std::size_t fetches_ = 0;            ///< nodes that have not been asked for
  modules::RingQueue<Cycle> leaving_;  ///< when those that have been, ahead of time, leave the memory scheduler's queue
  IntersectionPipelines box_, leaf_, transform_;
  bool transforms_leaves_;
  bool boxes_;            ///< primitive leaves are boxes: the shader tests what lies in them
  bool spreads_;          ///< events that take no time are touched one after the other
  Cycle usual_step_ = 0;  ///< from one of a lane's events that take time to the next, a running mean, in 16ths
  Cycle accounted_ = 0;   ///< cycles before it are counted as selections or stalls
  modules::Stall last_stall_{};
  modules::RtUnitCounters counters_;
};

}  // namespace grtx::sim::fast
