#include "grtx/modules/rt_unit/warp_buffer.h"

#include <algorithm>
#include <cassert>
#include <ostream>

#include "grtx/base/error.h"

namespace grtx::modules {

void WarpBuffer::Counters::add(const Counters& other) {
  calls += other.calls;
  occupancy_integral += other.occupancy_integral;
  max_stack_depth = std::max(max_stack_depth, other.max_stack_depth);
  for (std::size_t w = 0; w < kWarpWaits; ++w) warp_cycles[w] += other.warp_cycles[w];
  warp_latency.merge(other.warp_latency);
}

void WarpBuffer::Counters::describe(StatisticList& list, const std::string& prefix) const {
  list.add(prefix + ".calls", calls, "calls", "traceRay calls that entered the warp buffer");
  list.add(prefix + ".occupancy_integral", occupancy_integral, "warp cycles",
           "warps in the warp buffer, summed over cycles");
  for (std::size_t w = 0; w < kWarpWaits; ++w) {
    const std::string wait(kWarpWaitNames[w]);
    list.add(prefix + ".warp_cycles." + wait, warp_cycles[w], "warp cycles",
             "warps in the warp buffer by what they waited for, summed over cycles: " + wait);
  }
  list.add(prefix + ".max_stack_depth", max_stack_depth, "entries", "deepest traversal stack of a lane");
  list.add(prefix + ".warp_latency", warp_latency.mean(), "cycles", "mean time of a traceRay call in the warp buffer");
  list.add(prefix + ".warp_latency_max", warp_latency.max(), "cycles",
           "longest time of a traceRay call in the warp buffer");
}

WarpBuffer::WarpBuffer(const sc_core::sc_module_name& name, const Config& config, bool checkpoint)
    : sc_module(name), config_(config), checkpoint_(checkpoint) {
  if (config.entries < 1 || config.entries > 64)
    throw Error("configuration", "rt.warp_buffer.entries", "must be 1..64");
  warps_.resize(config.entries);
  ages_.resize(config.entries);
  all_ = config.entries == 64 ? ~LaneMask{0} : bit(config.entries) - 1;
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
    lane.stack_depth = replay ? 0 : 1;  // a round that does not replay starts with the root on the stack
    const LaneState state = events.empty() ? LaneState::finished : LaneState::ready;
    w.in[static_cast<std::size_t>(state)] |= bit(i);
  });
}

unsigned WarpBuffer::accept(Cycle now, const TraceCall& call) {
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
  const LaneMask b = bit(entry);
  if (occupied_ == 0) oldest_ = entry;
  occupied_ |= b;
  if (w.in_state(LaneState::ready) != 0) ready_ |= b;
  if (w.in_state(LaneState::finished) == w.lanes) done_ |= b;
  ++counters_.calls;
  return entry;
}

void WarpBuffer::release(Cycle now, unsigned entry) {
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

unsigned WarpBuffer::oldest(LaneMask entries) const {
  assert(entries != 0);
  auto best = static_cast<unsigned>(std::countr_zero(entries));
  for_each_bit(entries & (entries - 1), [&](unsigned e) {
    if (ages_[e] < ages_[best]) best = e;
  });
  return best;
}

unsigned WarpBuffer::find_slot(std::uint16_t slot) const {
  for (LaneMask m = occupied_; m != 0; m &= m - 1) {
    const auto e = static_cast<unsigned>(std::countr_zero(m));
    if (warps_[e].slot == slot) return e;
  }
  return config_.entries;
}

void WarpBuffer::settle(Cycle end) {
  if (end <= occupancy_from_) return;
  counters_.occupancy_integral += static_cast<std::uint64_t>(std::popcount(occupied_)) * (end - occupancy_from_);
  occupancy_from_ = end;
}

void WarpBuffer::count_waits() {
  for_each_bit(occupied_, [&](unsigned e) { count_wait(warps_[e]); });
}

Inventory WarpBuffer::inventory() const {
  const std::uint64_t lanes = std::uint64_t{config_.entries} * kMaxLanes;
  Inventory inventory{name(), {}, {}};
  auto& storage = inventory.storage;
  storage.push_back({"ray", StorageKind::ram, lanes * 8 * 32});   // origin, direction, t_min, t_max: 8 x fp32
  storage.push_back({"hit", StorageKind::ram, lanes * 2 * 32});   // t_hit, primitive id
  storage.push_back({"instance", StorageKind::ram, lanes * 64});  // address of the TLAS leaf the ray is inside
  storage.push_back({"stack", StorageKind::ram, lanes * config_.stack_entries * (64 + 32)});  // address, t
  storage.push_back({"status", StorageKind::flip_flop, lanes * 4});                           // ten lane states
  storage.push_back({"warp", StorageKind::flip_flop, std::uint64_t{config_.entries} * (16 + 16 + kMaxLanes)});
  if (checkpoint_) {
    // Paper, "Hardware cost": (1 bit + 2 B + 2 B) a lane, two base addresses and the maximum size of a buffer a unit.
    storage.push_back({"replay_flag", StorageKind::ram, lanes * 1, 1, 1, true});
    storage.push_back({"source_offset", StorageKind::ram, lanes * 16, 1, 1, true});
    storage.push_back({"destination_offset", StorageKind::ram, lanes * 16, 1, 1, true});
    storage.push_back({"source_base", StorageKind::flip_flop, 64, 1, 1, true});
    storage.push_back({"destination_base", StorageKind::flip_flop, 64, 1, 1, true});
    storage.push_back({"maximum_size", StorageKind::flip_flop, 16, 1, 1, true});
  }
  return inventory;
}

void WarpBuffer::dump_state(std::ostream& out) const {
  out << name() << ": " << std::popcount(occupied_) << " of " << config_.entries << " warps\n";
  for_each_bit(occupied_, [&](unsigned e) {
    const Warp& w = warps_[e];
    out << "  entry " << e << " slot " << w.slot << " group " << w.group->index << " round " << w.round << " accepted "
        << w.accepted;
    for (std::size_t s = 0; s < kLaneStates; ++s) {
      if (w.in[s] != 0) out << ' ' << kLaneStateNames[s] << '=' << std::popcount(w.in[s]);
    }
    out << '\n';
  });
}

}  // namespace grtx::modules
