// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/delayed_hits/delayed_hits.h"

#include <bit>
#include <ostream>
#include <string>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/decide/event_effect.h"

namespace grtx::modules {

DelayedHits::DelayedHits(const sc_core::sc_module_name& name, unsigned entries)
    : AnyHitModule(name), hits_(std::size_t{entries} * kMaxLanes), held_of_(entries) {}

void DelayedHits::end_of_elaboration() {
  warps_ = &warp_buffer->warps();
  client_ = client.operator->();
  batches_ = writer_of(batch);
  dones_ = reader_of(done);
}

void DelayedHits::arrive(Cycle now, LaneId id) {
  const Warp& warp = warps_->warp(entry_of(id));
  hits_[id].push_back(warp.lane[lane_of(id)].event);
  ++held_of_[entry_of(id)];
  ++held_;
  const LaneMask lane = bit(lane_of(id));
  warps_->move(entry_of(id), lane, LaneState::in_unit, LaneState::in_any_hit);
  client_->any_hit_done(now, {warp.slot, lane});  // the lane goes on
}

WarpMask DelayedHits::due_entries() const {
  WarpMask due = 0;
  if (held_ == 0) return due;
  for_each_bit(warps_->occupied(), [&](unsigned entry) {
    const Warp& warp = warps_->warp(entry);
    if (held_of_[entry] != 0 && warp.in_state(LaneState::waiting_any_hit) == warp.active()) due |= bit(entry);
  });
  return due;
}

void DelayedHits::invoke(Cycle now) {
  if (const AnyHitDone* arrived = dones_.front(now)) {
    answer(*arrived);
    dones_.pop(now);
  }
  const WarpMask due = due_entries();
  if (due != 0 && batches_.can_push(now)) fire(now, warps_->oldest(due));
}

void DelayedHits::answer(const AnyHitDone& answered) {
  const unsigned entry = warps_->find_slot(answered.slot);
  if (entry == warps_->entries() || (answered.lanes & ~warps_->warp(entry).in_state(LaneState::in_any_hit)) != 0) {
    throw Error("any-hit", "slot " + std::to_string(answered.slot), "only lanes at the shader can be done");
  }
  LaneMask left = 0;
  for_each_bit(answered.lanes, [&](unsigned lane) { left |= holds(lane_id(entry, lane)) ? bit(lane) : 0; });
  if (left != 0) warps_->move(entry, left, LaneState::in_any_hit, LaneState::waiting_any_hit);
  if (left != answered.lanes) warps_->move(entry, answered.lanes & ~left, LaneState::in_any_hit, LaneState::finished);
}

void DelayedHits::fire(Cycle now, unsigned entry) {
  const Warp& warp = warps_->warp(entry);
  AnyHitBatch message;
  message.slot = warp.slot;
  message.round = warp.round;
  for_each_bit(warp.in_state(LaneState::waiting_any_hit), [&](unsigned lane) {
    std::deque<traces::Event>& hits = hits_[lane_id(entry, lane)];
    add_lane(message, lane, hits.front());
    hits.pop_front();
  });
  const auto lanes = static_cast<unsigned>(std::popcount(message.lanes));
  held_ -= lanes;
  held_of_[entry] -= lanes;
  ++counters_.batches;
  counters_.lanes += lanes;
  batches_.push(now, message);
  warps_->move(entry, message.lanes, LaneState::waiting_any_hit, LaneState::in_any_hit);
}

Inventory DelayedHits::inventory() const {
  Inventory inventory{name(), {}, {}};
  inventory.storage.push_back({"found", StorageKind::ram, hits_.size() * 16, 1, 1, false, 16});  // hits of a round
  inventory.operators.push_back({"increment", 16, 1});
  return inventory;
}

void DelayedHits::dump_state(std::ostream& out) const {
  out << name() << ": " << held_ << " hits wait for their warps\n";
}

}  // namespace grtx::modules
