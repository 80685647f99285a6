// SPDX-License-Identifier: Apache-2.0

#include "grtx/rtl_tlm/observe/unit_probes.h"
#include <bit>
#include <stdexcept>
#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/rt_unit/checkpoint/checkpoint_unit.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/rtl_tlm/observe/wave_enumerations.h"

namespace grtx::sim {
namespace {

using modules::kCounterBits;
using modules::kLevelBits;
using modules::state_of;

/// A part of the RT unit by its name, or nullptr when this configuration does not elaborate it.
template <typename T>
const T* elaborated_part(const modules::RtUnitModule& rt, const std::string& name) {
  return dynamic_cast<const T*>(sc_core::sc_find_object((std::string(rt.name()) + "." + name).c_str()));
}

}  // namespace

Wire add_probe(Wires& wires, const std::string& unit, const modules::UnitProbe& probe) {
  return wires.add(unit + "." + probe.name, probe.width, probe.detail ? WaveLevel::signals : WaveLevel::units,
                   probe.is_state ? &unit_states() : nullptr);
}

RtUnitProbe::RtUnitProbe(Wires& wires, const std::string& scope, const modules::RtUnitModule& rt,
                         const traces::Header& header)
    : rt_(rt) {
  const std::size_t before = wires.selected();
  const std::vector<modules::PartInfo> parts = modules::part_table({}, {});
  for (const modules::PartInfo& part : parts) {
    const auto* scheduler = elaborated_part<modules::RtSchedulerState>(rt, part.name);
    if (scheduler == nullptr) continue;
    scheduler_ = scheduler;
    const std::string unit = scope + "." + part.name;
    issue_ = wires.add(unit + ".issue", 1);
    stall_ = wires.add(unit + ".stall_reason", width_for(modules::kStalls), WaveLevel::units, &stall_reasons());
    add_probes(wires, unit, elaborated_part<modules::Probed>(rt, part.name));
  }
  for (const modules::PartInfo& part : parts) {
    add_probes(wires, scope + "." + part.name, elaborated_part<modules::Probed>(rt, part.name));
  }
  const modules::WarpBuffer* buffer = nullptr;
  const modules::CheckpointState* checkpoint = nullptr;
  for (const modules::PartInfo& part : parts) {
    if (const auto* found = elaborated_part<modules::WarpBuffer>(rt, part.name)) buffer = found;
    if (const auto* found = elaborated_part<modules::CheckpointState>(rt, part.name)) checkpoint = found;
    Rtl rtl;
    rtl.block = elaborated_part<RtlSignals>(rt, part.name);
    if (rtl.block == nullptr) continue;
    for (const RtlSignal& signal : rtl.block->rtl_signals()) {
      const std::string wire = scope + "." + part.name + ".rtl." + signal.name;
      rtl.signals.push_back(wires.add(wire, signal.width, WaveLevel::signals));
    }
    rtl_.push_back(std::move(rtl));
  }
  for (unsigned entry = 0; buffer != nullptr && entry < buffer->warps().entries(); ++entry) {
    warps_.emplace_back(wires, scope + ".warp_buffer", buffer->warps(), entry, checkpoint, header);
  }
  selected_ = wires.selected() != before;
}

void RtUnitProbe::add_probes(Wires& wires, const std::string& unit, const modules::Probed* part) {
  if (part == nullptr || !parts_.insert(part).second) return;
  for (modules::UnitProbe& probe : part->probes()) {
    const std::size_t before = wires.selected();
    const Wire wire = add_probe(wires, unit, probe);
    if (wires.selected() != before) probes_.emplace_back(std::move(probe), wire);
  }
}

void RtUnitProbe::sample(Cycle now) {
  if (!selected_) return;
  if (scheduler_ != nullptr) {
    const unsigned stall = stalls_.look(now, rt_.accounted(), *scheduler_);
    issue_.set(stall == 0);
    stall_.set(stall);
  }
  for (auto& [probe, wire] : probes_) wire.set(probe.at(now));
  for (Rtl& rtl : rtl_) {
    for (std::size_t i = 0; i < rtl.signals.size(); ++i) rtl.signals[i].set(rtl.block->rtl_value(i, now));
  }
  for (WarpProbe& warp : warps_) warp.sample();
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
