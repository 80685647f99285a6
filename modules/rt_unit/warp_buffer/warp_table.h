// SPDX-License-Identifier: Apache-2.0
// The state of all warps and lanes in the warp buffer, shared by all parts of the RT unit. Plain C++.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/round_cursor.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_buffer_config.h"
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_wait.h"

namespace grtx::modules {

/// State of a lane; exactly one at a time.
enum class LaneState : std::uint8_t {
  idle,                      ///< not part of the call
  ready,                     ///< its next event can be handled when its warp is selected
  waiting_memory,            ///< node fetch in flight
  in_unit,                   ///< queued at or inside an intersection unit
  waiting_any_hit,           ///< has a hit, waits for the warp's any-hit batch
  in_any_hit,                ///< batch sent, waits for AnyHitDone
  waiting_checkpoint_read,   ///< source entry being read
  waiting_checkpoint_write,  ///< entries or the last sector not yet accepted by the checkpoint unit
  waiting_stack,             ///< stack entries being spilled or filled
  finished,
};
constexpr auto enum_names(LaneState) {
  return names_in_order<LaneState>({"idle", "ready", "waiting_memory", "in_unit", "waiting_any_hit", "in_any_hit",
                                    "checkpoint_read", "checkpoint_write", "stack", "finished"});
}
inline constexpr std::size_t kLaneStates = kCountOf<LaneState>;

struct Lane {
  const traces::Event* next = nullptr;  ///< event being handled, or to be handled next
  // Copies of next[0] and next[1], if they exist. When a fetch returns, the trace is usually no longer in the host's
  // cache; with the copies its read is needed only at the following return.
  traces::Event event;
  traces::Event following;
  std::uint32_t left = 0;  ///< events of the round from next[0] on
  std::uint32_t stack_depth = 0;

  void begin(std::span<const traces::Event> events) {
    next = events.data();
    left = static_cast<std::uint32_t>(events.size());
    if (left > 0) event = next[0];
    if (left > 1) following = next[1];
  }
  /// Moves to the next event. Returns false if there is none.
  bool advance() {
    ++next;
    event = following;
    if (--left > 1) following = next[1];
    return left != 0;
  }
};

struct Warp {
  const traces::RayGroup* group = nullptr;
  std::uint64_t age = 0;  ///< acceptance number; smaller is older
  std::uint32_t round = 0;
  std::uint16_t slot = 0;
  LaneMask lanes = 0;                      ///< lanes of the call
  std::array<LaneMask, kLaneStates> in{};  ///< [LaneState] lanes in this state
  Cycle accepted = 0;
  Cycle counted = 0;   ///< warp_cycles are counted up to this cycle (exclusive)
  bool walks = false;  ///< its lanes share a stack: the warp walk scheduler tells the reason of waiting (tell())
  WarpWait told = WarpWait::retire;
  Cycle any_hit_since = 0;  ///< cycle in which the first lane of the next batch began to wait
  LaneMask replaying = 0;   ///< lanes whose round began with a replay
  std::array<Lane, kMaxLanes> lane{};
  std::array<std::uint8_t, kMaxLanes> checkpoints{};  ///< [lane] checkpoint entries to submit once its stack is settled

  LaneMask in_state(LaneState s) const { return in[static_cast<std::size_t>(s)]; }
  LaneMask active() const { return lanes & ~in_state(LaneState::finished); }
  WarpWait wait() const {
    if (walks) return told;
    return wait_of(in_state(LaneState::ready), in_state(LaneState::waiting_memory),
                   in_state(LaneState::waiting_checkpoint_read) | in_state(LaneState::waiting_checkpoint_write),
                   in_state(LaneState::waiting_stack), in_state(LaneState::in_unit),
                   in_state(LaneState::waiting_any_hit) | in_state(LaneState::in_any_hit));
  }
};

/// Place of a warp's lane in the trace, for an Error: group, lane, round.
std::string place_in_trace(const Warp& warp, unsigned lane);

/// Initialises a warp for a call: lanes start at the first event of the round that `cursor` points to; lanes without
/// events are finished. The caller sets the age.
void begin_call(Warp& warp, const TraceCall& call, const RoundCursor& cursor, Cycle now);

class WarpTable {
 public:
  /// entries: warps, 1..64. Throws Error otherwise.
  explicit WarpTable(unsigned entries);

  unsigned entries() const { return static_cast<unsigned>(warps_.size()); }
  bool has_room() const { return occupied_ != all_; }
  bool empty() const { return occupied_ == 0; }
  /// Puts the call into the lowest free entry; lanes without events are finished at once. Returns the entry.
  unsigned accept(Cycle now, const TraceCall& call);
  /// Frees an entry whose lanes have all finished.
  void release(Cycle now, unsigned entry);

  Warp& warp(unsigned entry) { return warps_[entry]; }
  const Warp& warp(unsigned entry) const { return warps_[entry]; }
  Lane& lane(LaneId id) { return warps_[entry_of(id)].lane[lane_of(id)]; }
  WarpMask occupied() const { return occupied_; }      ///< one bit per entry
  WarpMask ready_entries() const { return ready_; }    ///< entries with a ready lane
  WarpMask finished_entries() const { return done_; }  ///< entries whose lanes have all finished
  const std::vector<std::uint64_t>& ages() const { return ages_; }
  /// Oldest of `entries` (not empty).
  unsigned oldest(WarpMask entries) const;
  /// Oldest warp in the buffer (not empty).
  const Warp& oldest_warp() const { return warps_[oldest_]; }
  /// Entry that holds the warp of warp slot `slot`; entries() if none does.
  unsigned find_slot(std::uint16_t slot) const;

  /// Moves lanes from one state to another; all of them must be in `from`.
  void move(unsigned entry, LaneMask lanes, LaneState from, LaneState to) {
    Warp& w = warps_[entry];
    LaneMask& source = w.in[static_cast<std::size_t>(from)];
    assert((source & lanes) == lanes);
    count_wait(w);
    source &= ~lanes;
    w.in[static_cast<std::size_t>(to)] |= lanes;
    const WarpMask b = bit(entry);
    const bool ready = w.walks ? w.told == WarpWait::ready : w.in_state(LaneState::ready) != 0;
    ready_ = ready ? ready_ | b : ready_ & ~b;
    note_done(entry);
  }
  /// Sets the reason for which a warp with a common stack waits. The warp is among ready_entries() when it is ready.
  void tell(unsigned entry, WarpWait wait) {
    Warp& w = warps_[entry];
    count_wait(w);
    w.walks = true;
    w.told = wait;
    ready_ = wait == WarpWait::ready ? ready_ | bit(entry) : ready_ & ~bit(entry);
  }
  /// Whether the lane is in state in_unit.
  bool in_unit(LaneId id) const {
    return entry_of(id) < warps_.size() && (warps_[entry_of(id)].in_state(LaneState::in_unit) & bit(lane_of(id))) != 0;
  }
  void note_stack_depth(std::uint32_t depth) {
    if (depth > counters_.max_stack_depth) counters_.max_stack_depth = depth;
  }

  /// Completes the occupancy integral up to `end` (exclusive).
  void settle(Cycle end);
  /// The occupancy integral up to `end`, without changing it.
  std::uint64_t occupancy_until(Cycle end) const {
    const Cycle open = end > occupancy_from_ ? end - occupancy_from_ : 0;
    return counters_.occupancy_integral + static_cast<std::uint64_t>(std::popcount(occupied_)) * open;
  }
  /// Attributes the cycles before `end` to the reason for which each warp waits now; call before states change. Lazy: a
  /// warp's cycles are added when its state next changes.
  void account(Cycle end) { waits_until_ = std::max(waits_until_, end); }
  /// Adds the pending cycles of all warps; call before reading the counters.
  void count_waits();
  const WarpBufferCounters& counters() const { return counters_; }
  /// Prints one indented line per warp.
  void dump_state(std::ostream& out) const;

 private:
  void note_done(unsigned entry) {
    const Warp& w = warps_[entry];
    if (w.in_state(LaneState::finished) == w.lanes) done_ |= bit(entry);
  }
  void count_wait(Warp& w) {
    if (w.counted == waits_until_) return;
    counters_.warp_cycles[static_cast<std::size_t>(w.wait())] += waits_until_ - w.counted;
    w.counted = waits_until_;
  }

  std::vector<Warp> warps_;
  std::vector<std::uint64_t> ages_;
  std::vector<RoundCursor> cursors_;  ///< [warp slot]
  WarpMask all_ = 0;
  WarpMask occupied_ = 0;
  WarpMask ready_ = 0;
  WarpMask done_ = 0;
  unsigned oldest_ = 0;  ///< entry of the oldest warp, if there is one
  std::uint64_t next_age_ = 0;
  Cycle occupancy_from_ = 0;
  Cycle waits_until_ = 0;
  WarpBufferCounters counters_;
};

}  // namespace grtx::modules
