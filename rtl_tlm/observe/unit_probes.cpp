// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/unit_probes.h"

#include <bit>
#include <stdexcept>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/rt_unit/any_hit_collector/any_hit_collector.h"
#include "grtx/modules/rt_unit/any_hit_unit/any_hit_unit.h"
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"
#include "grtx/modules/rt_unit/memory_scheduler/memory_scheduler.h"
#include "grtx/modules/rt_unit/prefetcher/sibling_prefetcher.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/rtl_tlm/observe/wave_enumerations.h"

namespace grtx::sim {
namespace {

using modules::LaneState;

constexpr unsigned kCounterBits = 48;
constexpr unsigned kLevelBits = 16;

/// A part of the RT unit by its name, or nullptr when this configuration does not elaborate it.
template <typename T>
const T* elaborated_part(const modules::RtUnitModule& rt, const std::string& name) {
  return dynamic_cast<const T*>(sc_core::sc_find_object((std::string(rt.name()) + "." + name).c_str()));
}

std::uint64_t state_of(bool waiting, bool busy) {
  return static_cast<std::uint64_t>(waiting ? UnitState::waiting : busy ? UnitState::busy : UnitState::idle);
}

}  // namespace

RtUnitProbe::RtUnitProbe(Wires& wires, const std::string& scope, const modules::RtUnitModule& rt,
                         const traces::Header& header)
    : rt_(rt),
      buffer_(elaborated_part<modules::WarpBuffer>(rt, "warp_buffer")),
      walk_(elaborated_part<modules::WarpWalkScheduler>(rt, "warp_walk_scheduler")),
      memory_(elaborated_part<modules::MemoryScheduler>(rt, "memory_scheduler")),
      any_hit_(elaborated_part<modules::AnyHitCollector>(rt, "any_hit_collector")),
      any_hit_unit_(elaborated_part<modules::AnyHitUnit>(rt, "any_hit_unit")),
      checkpoint_(elaborated_part<modules::CheckpointState>(rt, "checkpoint_unit")),
      prefetcher_(elaborated_part<modules::SiblingPrefetcher>(rt, "sibling_prefetcher")) {
  const std::size_t before = wires.selected();
  if (buffer_ != nullptr) warps_of_ = &buffer_->warps();
  const unsigned warps = warps_of_ != nullptr ? warps_of_->entries() : 64;
  const unsigned lanes = width_for(std::uint64_t{warps} * modules::kMaxLanes);
  const auto add = [&](const std::string& name, unsigned width, const Enumeration* enumeration = nullptr) {
    return wires.add(scope + "." + name, width, WaveLevel::units, enumeration);
  };
  const std::vector<modules::PartInfo> parts = modules::part_table({}, {});
  for (const modules::PartInfo& part : parts) {
    const auto* scheduler = elaborated_part<modules::RtSchedulerState>(rt, part.name);
    if (scheduler == nullptr) continue;
    scheduler_ = scheduler;
    issue_ = add(part.name + ".issue", 1);
    stall_ = add(part.name + ".stall_reason", width_for(modules::kStalls), &stall_reasons());
  }
  if (walk_ != nullptr) {
    walk_waiting_ = add("warp_walk_scheduler.waiting", kLevelBits);
    walk_under_way_ = add("warp_walk_scheduler.under_way", kLevelBits);
    walk_hits_ = add("warp_walk_scheduler.hits", kLevelBits);
  }
  if (warps_of_ != nullptr) {
    occupancy_ = add("warp_buffer.occupancy", width_for(warps));
    ready_ = add("warp_buffer.ready_warps", warps);
  }
  if (memory_ != nullptr) {
    memory_queue_ = add("memory_scheduler.queued", kLevelBits);
    memory_outstanding_ = add("memory_scheduler.outstanding", kLevelBits);
    fetches_ = wires.add(scope + ".memory_scheduler.node_sectors", kCounterBits, WaveLevel::signals);
  }
  for (const modules::PartInfo& part : parts) {
    Unit unit;
    unit.unit = elaborated_part<modules::IntersectionState>(rt, part.name);
    if (unit.unit == nullptr) continue;
    unit.state = add(part.name + ".state", 2, &unit_states());
    unit.busy = add(part.name + ".busy", kLevelBits);
    unit.queued = add(part.name + ".queued", lanes);
    unit.in_flight = add(part.name + ".in_flight", lanes);
    units_.push_back(unit);
  }
  if (any_hit_unit_ != nullptr) {
    heap_hits_ = add("any_hit_unit.hits_held", lanes);
    heap_handled_ = wires.add(scope + ".any_hit_unit.hits", kCounterBits, WaveLevel::signals);
    heap_entered_ = wires.add(scope + ".any_hit_unit.entered", kCounterBits, WaveLevel::signals);
  }
  if (any_hit_ != nullptr) {
    any_hit_waiting_ = add("any_hit_collector.lanes_waiting", lanes);
    any_hit_at_shader_ = add("any_hit_collector.lanes_at_shader", lanes);
    any_hit_timer_ = add("any_hit_collector.timer", kLevelBits);
    any_hit_batches_ = add("any_hit_collector.batches", kCounterBits);
    any_hit_timeouts_ = add("any_hit_collector.timeouts", kCounterBits);
  }
  if (checkpoint_ != nullptr) {
    ckpt_submitting_ = add("checkpoint_unit.lanes_submitting", lanes);
    ckpt_reading_ = add("checkpoint_unit.lanes_reading", lanes);
    ckpt_writes_ = add("checkpoint_unit.writes_queued", kLevelBits);
    ckpt_outstanding_ = add("checkpoint_unit.outstanding", kLevelBits);
    ckpt_written_ = add("checkpoint_unit.entries_written", kCounterBits);
    ckpt_read_ = add("checkpoint_unit.entries_read", kCounterBits);
  }
  for (const modules::PartInfo& part : parts) {
    Rtl rtl;
    rtl.block = elaborated_part<RtlSignals>(rt, part.name);
    if (rtl.block == nullptr) continue;
    for (const RtlSignal& signal : rtl.block->rtl_signals()) {
      const std::string wire = scope + "." + part.name + ".rtl." + signal.name;
      rtl.signals.push_back(wires.add(wire, signal.width, WaveLevel::signals));
    }
    rtl_.push_back(std::move(rtl));
  }
  if (prefetcher_ != nullptr) {
    prefetch_queue_ = add("sibling_prefetcher.queued", kLevelBits);
    prefetch_outstanding_ = add("sibling_prefetcher.outstanding", kLevelBits);
  }
  if (warps_of_ != nullptr) {
    for (unsigned entry = 0; entry < warps; ++entry) {
      warps_.emplace_back(wires, scope + ".warp_buffer", *warps_of_, entry, checkpoint_, header);
    }
  }
  selected_ = wires.selected() != before;
}

void RtUnitProbe::sample(Cycle now) {
  if (!selected_) return;
  if (scheduler_ != nullptr) {
    const unsigned stall = stalls_.look(now, rt_.accounted(), *scheduler_);
    issue_.set(stall == 0);
    stall_.set(stall);
  }
  if (walk_ != nullptr && warps_of_ != nullptr) sample_walk();
  if (warps_of_ != nullptr) {
    occupancy_.set(static_cast<unsigned>(std::popcount(warps_of_->occupied())));
    ready_.set(warps_of_->ready_entries());
  }
  if (memory_ != nullptr) {
    memory_queue_.set(memory_->queued());
    memory_outstanding_.set(memory_->outstanding());
    fetches_.set(memory_->counters().node_sectors());
  }
  for (Unit& unit : units_) {
    const unsigned busy = unit.unit->busy_pipelines(now);
    unit.state.set(state_of(unit.unit->queued() != 0, !unit.unit->idle() || busy != 0));
    unit.busy.set(busy);
    unit.queued.set(unit.unit->queued());
    unit.in_flight.set(unit.unit->in_flight());
  }
  if (any_hit_unit_ != nullptr) {
    const modules::AnyHitUnitCounters counters = any_hit_unit_->counters().unit;
    heap_hits_.set(any_hit_unit_->held());
    heap_handled_.set(counters.hits);
    heap_entered_.set(counters.entered);
  }
  if (any_hit_ != nullptr) {
    if (warps_of_ != nullptr) sample_any_hit(now);
    any_hit_batches_.set(any_hit_->counters().batches);
    any_hit_timeouts_.set(any_hit_->counters().timeouts);
  }
  if (checkpoint_ != nullptr) {
    ckpt_submitting_.set(checkpoint_->lanes_submitting());
    ckpt_reading_.set(checkpoint_->lanes_reading());
    ckpt_writes_.set(checkpoint_->writes_queued());
    ckpt_outstanding_.set(checkpoint_->outstanding());
    ckpt_written_.set(checkpoint_->counters().entries_written);
    ckpt_read_.set(checkpoint_->counters().entries_read);
  }
  for (Rtl& rtl : rtl_) {
    for (std::size_t i = 0; i < rtl.signals.size(); ++i) rtl.signals[i].set(rtl.block->rtl_value(i, now));
  }
  if (prefetcher_ != nullptr) {
    prefetch_queue_.set(prefetcher_->queued());
    prefetch_outstanding_.set(prefetcher_->outstanding());
  }
  for (WarpProbe& warp : warps_) warp.sample();
}

// Entries that wait in the RT unit, nodes under way and hits of all its warps.
void RtUnitProbe::sample_walk() {
  std::uint64_t waiting = 0, under_way = 0, hits = 0;
  modules::for_each_bit(warps_of_->occupied(), [&](unsigned entry) {
    waiting += walk_->stack_of(entry).waiting();
    under_way += walk_->stack_of(entry).under_way();
    hits += walk_->hits_of(entry);
  });
  walk_waiting_.set(waiting);
  walk_under_way_.set(under_way);
  walk_hits_.set(hits);
}

void RtUnitProbe::sample_any_hit(Cycle now) {
  unsigned waiting = 0;
  unsigned at_shader = 0;
  Cycle timer = 0;
  modules::for_each_bit(warps_of_->occupied(), [&](unsigned entry) {
    const modules::Warp& warp = warps_of_->warp(entry);
    const LaneMask lanes = warp.in_state(LaneState::waiting_any_hit);
    waiting += static_cast<unsigned>(std::popcount(lanes));
    at_shader += static_cast<unsigned>(std::popcount(warp.in_state(LaneState::in_any_hit)));
    if (lanes != 0) timer = std::max(timer, now - warp.any_hit_since);
  });
  any_hit_waiting_.set(waiting);
  any_hit_at_shader_.set(at_shader);
  any_hit_timer_.set(std::min<Cycle>(timer, (1u << kLevelBits) - 1));
}

SimtProbe::SimtProbe(Wires& wires, const std::string& scope, const modules::SimtCore& simt) : simt_(simt) {
  const std::size_t before = wires.selected();
  const unsigned warps = width_for(simt.slots());
  resident_ = wires.add(scope + ".resident", warps);
  for (std::size_t a = 0; a < modules::kWarpActivities; ++a) {
    warps_[a] = wires.add(scope + ".warps_" + std::string(name_at<modules::WarpActivity>(a)), warps);
  }
  queued_ = wires.add(scope + ".load_store_queued", 20);
  in_flight_ = wires.add(scope + ".load_store_in_flight", 20);
  const std::size_t units = wires.selected();
  for (unsigned i = 0; i < simt.slots(); ++i) {
    const std::string slot = scope + ".slot" + std::to_string(i);
    Slot wires_of;
    wires_of.activity = wires.add(slot + ".activity", 3, WaveLevel::signals, &activities());
    wires_of.group = wires.add(slot + ".group", 32, WaveLevel::signals);
    wires_of.round = wires.add(slot + ".round", 32, WaveLevel::signals);
    slots_.push_back(wires_of);
  }
  selected_ = wires.selected() != before;
  slots_selected_ = wires.selected() != units;
}

void SimtProbe::sample() {
  if (!selected_) return;
  if (simt_.last_active() == seen_) return;
  seen_ = simt_.last_active();
  std::array<unsigned, modules::kWarpActivities> warps{};
  unsigned resident = 0;
  for (unsigned i = 0; i < slots_.size(); ++i) {
    if (!simt_.occupied(i)) {
      slots_[i].activity.set(0);
      continue;
    }
    const auto activity = static_cast<std::size_t>(simt_.activity(i));
    ++warps[activity];
    ++resident;
    if (!slots_selected_) continue;
    slots_[i].activity.set(activity + 1);
    slots_[i].group.set(simt_.group(i).index);
    slots_[i].round.set(simt_.round(i));
  }
  resident_.set(resident);
  for (std::size_t a = 0; a < warps.size(); ++a) warps_[a].set(warps[a]);
  queued_.set(simt_.load_store().queued());
  in_flight_.set(simt_.load_store().in_flight());
}

L1Probe::L1Probe(Wires& wires, const std::string& scope, const modules::L1Cache& l1) : l1_(l1) {
  const std::size_t before = wires.selected();
  state_ = wires.add(scope + ".state", 2, WaveLevel::units, &unit_states());
  mshr_ = wires.add(scope + ".mshr", kLevelBits);
  misses_ = wires.add(scope + ".misses_queued", kLevelBits);
  writes_ = wires.add(scope + ".writes_pending", kLevelBits);
  fills_ = wires.add(scope + ".fills", kCounterBits, WaveLevel::signals);
  stalls_ = wires.add(scope + ".stalls", kCounterBits, WaveLevel::signals);
  selected_ = wires.selected() != before;
}

void L1Probe::sample() {
  if (!selected_) return;
  const modules::L1Counters& counters = l1_.raw_counters();
  std::uint64_t stalls = 0;
  for (const std::uint64_t count : counters.stalls) stalls += count;
  const std::size_t mshr = l1_.mshr_used();
  state_.set(state_of(mshr != 0, !l1_.idle()));
  mshr_.set(mshr);
  misses_.set(l1_.misses_queued());
  writes_.set(l1_.writes_pending());
  fills_.set(counters.fills);
  stalls_.set(stalls);
}

L2Probe::L2Probe(Wires& wires, const std::string& scope, const modules::L2Slice& slice) : slice_(slice) {
  const std::size_t before = wires.selected();
  state_ = wires.add(scope + ".state", 2, WaveLevel::units, &unit_states());
  mshr_ = wires.add(scope + ".mshr", kLevelBits);
  accesses_ = wires.add(scope + ".accesses_queued", kLevelBits);
  replies_ = wires.add(scope + ".replies_queued", kLevelBits);
  dram_queue_ = wires.add(scope + ".dram_queued", kLevelBits);
  dram_outstanding_ = wires.add(scope + ".dram_outstanding", kLevelBits);
  selected_ = wires.selected() != before;
}

void L2Probe::sample() {
  if (!selected_) return;
  const std::size_t mshr = slice_.mshr_used();
  state_.set(state_of(mshr != 0, !slice_.idle()));
  mshr_.set(mshr);
  accesses_.set(slice_.accesses_queued());
  replies_.set(slice_.replies_queued());
  dram_queue_.set(slice_.dram_queued());
  dram_outstanding_.set(slice_.dram.outstanding());
}

}  // namespace grtx::sim
