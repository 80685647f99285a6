// SPDX-License-Identifier: Apache-2.0
// Event sampling of a sampled run: one in `stride` of a lane's events is timed. The others are executed functionally
// when the lane is next served; before that they touch the caches one by one, spread over the time between two timed
// events.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/sampling.h"
#include "grtx/modules/rt_unit/warp_table.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// Functional execution of untimed events, implemented by the RT scheduler.
class functional_events_if {
 public:
  /// The event, the lane's current one or a later one, accesses caches and prefetcher functionally in cycle `at`.
  virtual void touch_event(LaneId id, const traces::Event& event, Cycle at) = 0;
  /// Like touch_event() for a timed event, which accesses the caches itself: only the prefetcher is told.
  virtual void note_event(LaneId id, const traces::Event& event) = 0;
  /// Executes all other effects of the lane's event and advances the lane to the next one.
  virtual void execute(LaneId id, Cycle at) = 0;

 protected:
  ~functional_events_if() = default;
};

class EventSampler {
 public:
  /// entries: warps of the warp buffer. `events` must outlive it.
  EventSampler(const Sampling& sampling, unsigned entries, functional_events_if& events);

  /// Sets the warp table; called once, at the end of elaboration.
  void watch(WarpTable& warps) { warps_ = &warps; }
  /// The lanes of `entry` begin a round: executes the events before the first timed one. Lanes without a timed event
  /// are finished.
  void begin(unsigned entry, Cycle now);
  /// Advances a lane of the served warp to its next timed event, which begins now. Returns false if there is none.
  bool advance(LaneId id, Cycle now);
  /// Lets the untimed events that are due by `now` touch the caches.
  void touch_until(Cycle now);
  void restart();

 private:
  struct LaneEvents {
    const traces::Event* touched = nullptr;    ///< first event that has not touched the caches yet
    const traces::Event* touch_end = nullptr;  ///< next timed event, as far as known
    Cycle began = kNever;                      ///< start of its last timed event
    Cycle pace = 1;                            ///< cycles between the touches of two untimed events
    std::uint32_t rest = 0;      ///< untimed events of the current block (stride events) after its timed one
    std::uint32_t before = 0;    ///< untimed events of the next block before its timed one
    std::uint32_t instance = 0;  ///< address of the last instance leaf seen by plan()
    bool fresh = false;          ///< the current event is the round's first timed one
    bool waiting = false;        ///< in the wheel
  };
  static constexpr std::size_t kWheel = 4096;        ///< range of the timing wheel, in cycles
  static constexpr std::uint64_t kMostStrides = 64;  ///< upper bound of the stride, so that seeds are distinct
  static constexpr unsigned kMemory = 16;            ///< window of the running average step(), in timed events

  void plan(LaneId id, const traces::Event* first, std::uint32_t left);
  bool skip(LaneId id, std::uint32_t count, Cycle now);
  void start_touches(LaneId id, Cycle now);
  void touch(LaneId id, Cycle now);
  void put_off(LaneId id, Cycle until);
  Cycle step() const { return step_sum_ / kMemory; }

  Sampling sampling_;
  functional_events_if& events_;
  WarpTable* warps_ = nullptr;
  std::vector<LaneEvents> lanes_;
  std::vector<std::uint64_t> seeds_;        ///< [entry] seed of the hash that selects timed events
  std::vector<std::vector<LaneId>> wheel_;  ///< [cycle % kWheel]
  Cycle touched_until_ = 0;                 ///< first cycle of the wheel that has not been processed
  Cycle step_sum_;                          ///< kMemory times the average time between a lane's timed events
};

}  // namespace grtx::modules
