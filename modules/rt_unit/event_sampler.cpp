// SPDX-License-Identifier: Apache-2.0
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
      seeds_(entries),
      wheel_(kWheel),
      step_sum_(kFirstStep * kMemory) {}

void EventSampler::restart() {
  std::fill(lanes_.begin(), lanes_.end(), LaneEvents());
  for (std::vector<LaneId>& due : wheel_) due.clear();
  touched_until_ = 0;
  step_sum_ = kFirstStep * kMemory;
}

void EventSampler::begin(unsigned entry, Cycle now) {
  constexpr std::uint64_t kMostRounds = 4096;  // upper bound, so that keys are distinct
  const Warp& warp = warps_->warp(entry);
  seeds_[entry] = Sampling::mixed((warp.group->index * kMostRounds + warp.round) * kMostStrides + sampling_.offset);
  for_each_bit(warp.lanes, [&](unsigned i) {
    const LaneId id = lane_id(entry, i);
    const Lane& lane = warp.lane[i];
    LaneEvents& s = lanes_[id];
    const bool waiting = s.waiting;
    s = LaneEvents();
    s.touched = s.touch_end = lane.next;
    s.fresh = true;
    s.waiting = waiting;
    if (lane.left == 0) return;
    plan(id, lane.next, lane.left);
    s.rest = sampling_.stride - 1 - s.before;
    if (!skip(id, s.before, now)) warps_->move(entry, bit(i), LaneState::ready, LaneState::finished);
  });
}

bool EventSampler::advance(LaneId id, Cycle now) {
  LaneEvents& s = lanes_[id];
  if (!std::exchange(s.fresh, false)) {
    if (!skip(id, s.rest + s.before, now)) return false;
    s.rest = sampling_.stride - 1 - s.before;
  }
  start_touches(id, now);
  return true;
}

/// Chooses the timed event of the next block of `stride` events, which begins with `first`: the one with the smallest
/// hash. left: number of events left in the round.
void EventSampler::plan(LaneId id, const traces::Event* first, std::uint32_t left) {
  LaneEvents& s = lanes_[id];
  const std::uint64_t seed = seeds_[entry_of(id)];
  std::uint64_t least = ~std::uint64_t{0};
  s.before = 0;
  for (std::uint32_t i = 0; i < sampling_.stride; ++i) {
    std::uint64_t key = 0;
    if (i < left) {
      const traces::Event& event = first[i];
      if (event.kind() == traces::EventKind::visit_instance) s.instance = event.node;
      key = (std::uint64_t{s.instance} << 35) ^ (std::uint64_t{event.node} << 3) ^ static_cast<unsigned>(event.kind());
    } else {  // the round ends within the block: place-holders after its end, so possibly no event is timed
      key = ~((std::uint64_t{left} << 32) + (i << 6) + lane_of(id));
    }
    const std::uint64_t hash = Sampling::mixed(seed ^ key);
    if (hash < least) {
      least = hash;
      s.before = i;
    }
  }
}

/// Executes `count` events functionally. Returns false if the lane has no event left.
bool EventSampler::skip(LaneId id, std::uint32_t count, Cycle now) {
  const Lane& lane = warps_->lane(id);
  LaneEvents& s = lanes_[id];
  for (; count > 0 && lane.left > 0; --count) {
    const Cycle at = now - std::min(now, count * step() / sampling_.stride);
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
  s.before = 0;
  if (lane.left > 1 + s.rest) plan(id, lane.next + 1 + s.rest, lane.left - 1 - s.rest);
  const std::uint32_t untimed = std::min<std::uint32_t>(lane.left - 1, s.rest + s.before);
  s.touch_end = lane.next + 1 + untimed;
  if (s.touched >= s.touch_end) return;
  s.pace = std::clamp<Cycle>(step() / (untimed + 1), 1, kWheel - 1);
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
