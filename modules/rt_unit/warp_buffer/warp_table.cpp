// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"

#include <algorithm>
#include <cassert>
#include <ostream>

#include "grtx/base/error.h"

namespace grtx::modules {

const CounterTable<WarpBufferCounters>& WarpBufferCounters::table() {
  using C = WarpBufferCounters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .exact(&C::calls, "calls", "calls", "traceRay calls that entered the warp buffer")
          .sum(&C::occupancy_integral, "occupancy_integral", "warp cycles",
               "warps in the warp buffer, summed over cycles")
          .by_name<WarpWait>(&C::warp_cycles, "warp_cycles", "warp cycles",
                             "warps in the warp buffer by what they waited for, summed over cycles: {}")
          .largest(&C::max_stack_depth, "max_stack_depth", "entries", "deepest traversal stack of a lane")
          .distribution(&C::warp_latency, "warp_latency", "cycles", "mean time of a traceRay call in the warp buffer",
                        "longest time of a traceRay call in the warp buffer");
  return table;
}

WarpTable::WarpTable(unsigned entries) {
  if (entries < 1 || entries > 64) throw Error("configuration", "rt.warp_buffer.entries", "must be 1..64");
  warps_.resize(entries);
  ages_.resize(entries);
  all_ = entries == 64 ? ~WarpMask{0} : bit(entries) - 1;
}

std::string place_in_trace(const Warp& warp, unsigned lane) {
  return "group " + std::to_string(warp.group->index) + " lane " + std::to_string(lane) + " round " +
         std::to_string(warp.round);
}

void begin_call(Warp& w, const TraceCall& call, const RoundCursor& cursor, Cycle now) {
  w.group = call.group;
  w.round = call.round;
  w.slot = call.slot;
  w.lanes = call.lanes;
  w.in.fill(0);
  w.replaying = 0;
  w.accepted = now;
  for_each_bit(call.lanes, [&](unsigned i) {
    const auto events = cursor.events(i);
    Lane& lane = w.lane[i];
    lane.begin(events);
    const bool replay = cursor.round(i).replay;
    if (replay) w.replaying |= bit(i);
    lane.stack_depth = replay ? 0 : 1;  // without replay the stack initially holds the root
    const LaneState state = events.empty() ? LaneState::finished : LaneState::ready;
    w.in[static_cast<std::size_t>(state)] |= bit(i);
  });
}

unsigned WarpTable::accept(Cycle now, const TraceCall& call) {
  assert(has_room() && call.group != nullptr);
  settle(now + 1);  // the warp occupies the buffer from the next cycle on
  const auto entry = static_cast<unsigned>(std::countr_zero(~occupied_));
  if (call.slot >= cursors_.size()) cursors_.resize(call.slot + std::size_t{1});
  RoundCursor& cursor = cursors_[call.slot];
  cursor.seek(*call.group, call.round);

  Warp& w = warps_[entry];
  begin_call(w, call, cursor, now);
  w.counted = waits_until_;
  w.age = next_age_++;
  ages_[entry] = w.age;
  const WarpMask b = bit(entry);
  if (occupied_ == 0) oldest_ = entry;
  occupied_ |= b;
  if (w.in_state(LaneState::ready) != 0) ready_ |= b;
  if (w.in_state(LaneState::finished) == w.lanes) done_ |= b;
  ++counters_.calls;
  return entry;
}

void WarpTable::release(Cycle now, unsigned entry) {
  assert((done_ & bit(entry)) != 0);
  settle(now + 1);
  count_wait(warps_[entry]);
  occupied_ &= ~bit(entry);
  done_ &= ~bit(entry);
  ready_ &= ~bit(entry);
  counters_.warp_latency.add(now - warps_[entry].accepted);
  warps_[entry].group = nullptr;
  if (occupied_ != 0) oldest_ = oldest(occupied_);
}

unsigned WarpTable::oldest(WarpMask entries) const {
  assert(entries != 0);
  auto best = static_cast<unsigned>(std::countr_zero(entries));
  for_each_bit(entries & (entries - 1), [&](unsigned e) {
    if (ages_[e] < ages_[best]) best = e;
  });
  return best;
}

unsigned WarpTable::find_slot(std::uint16_t slot) const {
  for (WarpMask m = occupied_; m != 0; m &= m - 1) {
    const auto e = static_cast<unsigned>(std::countr_zero(m));
    if (warps_[e].slot == slot) return e;
  }
  return entries();
}

void WarpTable::settle(Cycle end) {
  if (end <= occupancy_from_) return;
  counters_.occupancy_integral += static_cast<std::uint64_t>(std::popcount(occupied_)) * (end - occupancy_from_);
  occupancy_from_ = end;
}

void WarpTable::count_waits() {
  for_each_bit(occupied_, [&](unsigned e) { count_wait(warps_[e]); });
}

void WarpTable::dump_state(std::ostream& out) const {
  for_each_bit(occupied_, [&](unsigned e) {
    const Warp& w = warps_[e];
    out << "  entry " << e << " slot " << w.slot << " group " << w.group->index << " round " << w.round << " accepted "
        << w.accepted;
    for (std::size_t s = 0; s < kLaneStates; ++s) {
      if (w.in[s] != 0) out << ' ' << name_at<LaneState>(s) << '=' << std::popcount(w.in[s]);
    }
    out << '\n';
  });
}

}  // namespace grtx::modules
