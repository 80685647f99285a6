#include "grtx/modules/rt_unit/event_sampler.h"

#include <algorithm>
#include <utility>

namespace grtx::modules {

namespace {
constexpr Cycle kFirstStep = 200;  ///< cycles; initial value of the average step
}  // namespace

EventSampler::EventSampler(const Sampling& sampling, unsigned entries, functional_events_if& events)
    : sampling_(sampling),
      events_(events),
      lanes_(std::size_t{entries} * kMaxLanes),
      served_(entries),
      wheel_(kWheel),
      step_sum_(kFirstStep * kMemory) {}

void EventSampler::restart() {
  std::fill(lanes_.begin(), lanes_.end(), LaneEvents());
  std::fill(served_.begin(), served_.end(), 0);
  for (std::vector<LaneId>& due : wheel_) due.clear();
  touched_until_ = 0;
  step_sum_ = kFirstStep * kMemory;
}

// All lanes of a warp start at the same position, so that lanes on the same path still visit the same nodes together.
void EventSampler::begin(unsigned entry, Cycle now) {
  constexpr std::uint64_t kMostRounds = 4096;  // only for distinct keys
  const Warp& warp = warps_->warp(entry);
  const unsigned at = sampling_.first(warp.group->index * kMostRounds + warp.round);
  served_[entry] = now;
  for_each_bit(warp.lanes, [&](unsigned i) {
    const LaneId id = lane_id(entry, i);
    const Lane& lane = warp.lane[i];
    const bool waiting = lanes_[id].waiting;
    lanes_[id] = LaneEvents();
    lanes_[id].touched = lanes_[id].touch_end = lane.next;
    lanes_[id].fresh = true;
    lanes_[id].waiting = waiting;
    if (lane.left == 0 || at == 0) return;
    if (!skip(id, sampling_.stride - at, 0, now)) {
      warps_->move(entry, bit(i), LaneState::ready, LaneState::finished);
    }
  });
}

void EventSampler::serve(unsigned entry, Cycle now) { apart_ = now - std::exchange(served_[entry], now); }

bool EventSampler::advance(LaneId id, Cycle now) {
  LaneEvents& s = lanes_[id];
  const std::uint32_t between = sampling_.stride - 1;
  if (!std::exchange(s.fresh, false)) {
    if (!skip(id, std::exchange(s.owed, 0u), between, now)) return false;
    for (std::uint32_t i = 0; i < between; ++i) {
      // An event whose node its warp is already fetching waits for it, as it would if all events were timed.
      if (events_.joins_for(id, now) > i * apart_) {
        s.owed = between - i;
        break;
      }
      if (!skip(id, 1, between - i - 1, now)) return false;
    }
  }
  start_touches(id, now);
  return true;
}

/// Executes `count` events functionally; `more` untimed ones follow before `now`. Returns false if the lane has no
/// event left.
bool EventSampler::skip(LaneId id, std::uint32_t count, std::uint32_t more, Cycle now) {
  const Lane& lane = warps_->lane(id);
  LaneEvents& s = lanes_[id];
  for (; count > 0 && lane.left > 0; --count) {
    const Cycle at = now - std::min(now, (count + more) * step() / sampling_.stride);
    if (lane.next >= s.touched) {
      events_.touch_event(id, lane.event, at);
      s.touched = lane.next + 1;
    }
    events_.execute(id, at);
  }
  return lane.left > 0;
}

void EventSampler::start_touches(LaneId id, Cycle now) {
  LaneEvents& s = lanes_[id];
  const Lane& lane = warps_->lane(id);
  if (s.began != kNever) step_sum_ += now - s.began - step();
  s.began = now;
  if (s.touched <= lane.next) {
    events_.note_event(id, lane.event);
    s.touched = lane.next + 1;
  }
  const std::uint32_t behind = std::min<std::uint32_t>(lane.left - 1, s.owed + sampling_.stride - 1);
  s.touch_end = lane.next + 1 + behind;
  if (s.touched >= s.touch_end) return;
  s.pace = std::clamp<Cycle>(step() / (behind + 1), 1, kWheel - 1);
  if (!s.waiting) put_off(id, now + s.pace);
}

void EventSampler::put_off(LaneId id, Cycle until) {
  lanes_[id].waiting = true;
  wheel_[until % kWheel].push_back(id);
}

void EventSampler::touch(LaneId id, Cycle now) {
  LaneEvents& s = lanes_[id];
  s.waiting = false;
  const Warp& warp = warps_->warp(entry_of(id));
  if (warp.group == nullptr || s.touched >= s.touch_end) return;
  const Lane& lane = warp.lane[lane_of(id)];
  if (lane.left == 0 || s.touched < lane.next) return;
  events_.touch_event(id, *s.touched++, now);
  if (s.touched < s.touch_end) put_off(id, now + s.pace);
}

void EventSampler::touch_until(Cycle now) {
  if (touched_until_ + kWheel <= now) {  // the unit slept: waiting events touch the caches when they are executed
    for (std::vector<LaneId>& due : wheel_) {
      for (const LaneId id : due) lanes_[id].waiting = false;
      due.clear();
    }
    touched_until_ = now + 1;
    return;
  }
  for (; touched_until_ <= now; ++touched_until_) {
    std::vector<LaneId>& due = wheel_[touched_until_ % kWheel];
    for (std::size_t i = 0; i < due.size(); ++i) touch(due[i], touched_until_);
    due.clear();
  }
}

}  // namespace grtx::modules
