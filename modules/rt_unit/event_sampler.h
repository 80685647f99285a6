// Which of a lane's events take time in a sampled run: one in `stride`. The others are executed when the lane is served
// next; between, they meet the caches one after the other, at the pace at which the lane goes on.
#pragma once

#include <cstdint>
#include <vector>

#include "grtx/modules/kernel/clock_domain.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/sampling.h"
#include "grtx/modules/rt_unit/warp_table.h"
#include "grtx/traces/event.h"

namespace grtx::modules {

/// Who executes events without time: the RT scheduler.
class functional_events_if {
 public:
  /// An event of the lane, its present one or a later one, meets the caches and the prefetcher in cycle `at`.
  virtual void touch_event(LaneId id, const traces::Event& event, Cycle at) = 0;
  /// The same event is one that takes time: the prefetcher alone hears of it.
  virtual void note_event(LaneId id, const traces::Event& event) = 0;
  /// Does all else that the lane's event does and moves the lane on to the next one.
  virtual void execute(LaneId id, Cycle at) = 0;
  /// Cycles until a fetch of the lane's node by its own warp is back; 0: there is none that it could join.
  virtual Cycle joins_for(LaneId id, Cycle now) const = 0;

 protected:
  ~functional_events_if() = default;
};

class EventSampler {
 public:
  /// entries: warps of the warp buffer. `events` must outlive it.
  EventSampler(const Sampling& sampling, unsigned entries, functional_events_if& events);

  /// The warps, once they are known.
  void watch(WarpTable& warps) { warps_ = &warps; }
  /// The lanes of `entry` begin a round: events before the first that takes time are executed. Lanes that have no other
  /// are finished.
  void begin(unsigned entry, Cycle now);
  /// A warp is served.
  void serve(unsigned entry, Cycle now);
  /// Moves a lane of the warp that is served to its next event that takes time, which begins now; false: it has none.
  bool advance(LaneId id, Cycle now);
  /// Events without time meet the caches, those that are due by now.
  void touch_until(Cycle now);
  void restart();

 private:
  struct LaneEvents {
    const traces::Event* touched = nullptr;    ///< the first that has not met the caches
    const traces::Event* touch_end = nullptr;  ///< the next that takes time, as far as is known
    Cycle began = kNever;                      ///< its last event that took time
    Cycle pace = 1;                            ///< cycles from one event without time to the next
    std::uint32_t owed = 0;                    ///< events without time that a join has put off
    bool fresh = false;                        ///< its present event takes time
    bool waiting = false;                      ///< in the wheel
  };
  static constexpr std::size_t kWheel = 4096;  ///< cycles that an event is put off at most
  static constexpr unsigned kMemory = 16;      ///< steps over which usual_step_ is averaged

  bool skip(LaneId id, std::uint32_t count, std::uint32_t more, Cycle now);
  void start_touches(LaneId id, Cycle now);
  void touch(LaneId id, Cycle now);
  void put_off(LaneId id, Cycle until);
  Cycle step() const { return step_sum_ / kMemory; }

  Sampling sampling_;
  functional_events_if& events_;
  WarpTable* warps_ = nullptr;
  std::vector<LaneEvents> lanes_;
  std::vector<Cycle> served_;               ///< by entry: last
  Cycle apart_ = 0;                         ///< between the last two services of the warp that is served
  std::vector<std::vector<LaneId>> wheel_;  ///< by cycle, modulo kWheel
  Cycle touched_until_ = 0;                 ///< the first cycle of the wheel that has not come
  Cycle step_sum_;                          ///< kMemory times the usual time of a lane's event
};

}  // namespace grtx::modules
