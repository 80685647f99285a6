// SPDX-License-Identifier: Apache-2.0
#include "grtx/rtl_tlm/observe/timeline.h"

#include <fmt/format.h>

#include <bit>
#include <string_view>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"
#include "grtx/modules/rt_unit/rt_unit_table.h"
#include "grtx/modules/rt_unit/scheduler/scheduler_base.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer.h"
#include "grtx/modules/simt/decide/simt_core_config.h"
#include "grtx/modules/simt/simt_core.h"

namespace grtx::sim {
namespace {

template <typename T>
const T* part(const modules::RtUnitModule& rt, const std::string& name) {
  return dynamic_cast<const T*>(sc_core::sc_find_object((std::string(rt.name()) + "." + name).c_str()));
}

double rate(std::uint64_t part_of, std::uint64_t all) {
  return all == 0 ? 0.0 : static_cast<double>(part_of) / static_cast<double>(all);
}

}  // namespace

Timeline::Timeline(const TimelineOptions& options, Gpu& gpu, const MemorySystem& memory, const std::string& trace_hash,
                   const std::string& config_hash)
    : options_(options),
      gpu_(gpu),
      memory_(memory),
      writer_(options.path, {{"program", std::string("grtx ") + GRTX_VERSION},
                             {"trace", trace_hash},
                             {"config", config_hash},
                             {"core_period_fs", std::to_string(gpu.core().period_fs())}}),
      observation_("timeline", gpu.core(), options.window, *this) {
  for (const auto& sm : gpu.sms()) {
    SmTracks& tracks = sms_.emplace_back();
    tracks.process = writer_.process(sm->name());
    for (const auto& rt : sm->rt_units()) {
      RtTracks& unit_of = tracks.rt_units.emplace_back();
      // The parts of the first RT unit carry no number: most SMs have one.
      const std::string prefix = tracks.rt_units.size() == 1 ? "" : std::string(rt->basename()) + ".";
      unit_of.rt = rt.get();
      for (const modules::PartInfo& of : modules::part_table({}, {})) {
        if (const auto* scheduler = part<modules::RtSchedulerState>(*rt, of.name)) {
          unit_of.scheduler = scheduler;
          unit_of.scheduler_track.track = writer_.track(tracks.process, prefix + of.name);
        }
        if (const auto* buffer = part<modules::WarpBuffer>(*rt, of.name)) unit_of.buffer = buffer;
        const auto* unit = part<modules::IntersectionState>(*rt, of.name);
        if (unit == nullptr) continue;
        unit_of.units.push_back(unit);
        unit_of.unit_tracks.push_back({writer_.track(tracks.process, prefix + of.name), kNothing, ""});
      }
    }
    tracks.l1.track = writer_.track(tracks.process, "l1d");
    tracks.l1_cache = dynamic_cast<const modules::L1Cache*>(&sm->l1());
    tracks.simt = dynamic_cast<const modules::SimtCore*>(&sm->simt());
    for (unsigned i = 0; tracks.simt != nullptr && i < tracks.simt->slots(); ++i) {
      tracks.slots.push_back({writer_.track(tracks.process, fmt::format("warp slot {}", i)), false, 0, 0, kNothing});
    }
  }
  memory_process_ = writer_.process("gpu.memory");
  for (std::size_t i = 0; i < gpu.slices().size(); ++i) {
    slices_.push_back({writer_.track(memory_process_, fmt::format("l2_slice{}", i)), kNothing, ""});
  }
  for (unsigned i = 0; i < memory.channels(); ++i) {
    channels_.push_back({writer_.track(memory_process_, fmt::format("dram.channel{}", i)), kNothing, ""});
  }
}

void Timeline::show_slot(Slot& slot, const modules::SimtCore& simt, unsigned index, Cycle now) {
  if (!simt.occupied(index)) {
    if (slot.occupied) {
      while (writer_.depth(slot.track) > 0) writer_.end(slot.track, now);
      slot.occupied = false;
    }
    return;
  }
  const auto activity = static_cast<unsigned>(simt.activity(index));
  const std::uint32_t group = simt.group(index).index;
  const std::uint32_t round = simt.round(index);
  const bool new_warp = !slot.occupied || slot.group != group;
  const bool new_round = new_warp || slot.round != round;
  if (!new_round && slot.activity == activity) return;
  if (slot.occupied) writer_.end(slot.track, now);               // the activity
  if (slot.occupied && new_round) writer_.end(slot.track, now);  // the round
  if (slot.occupied && new_warp) writer_.end(slot.track, now);
  if (new_warp) writer_.begin(slot.track, now, fmt::format("warp {}", group), {{"group", group}});
  if (new_round) writer_.begin(slot.track, now, fmt::format("round {}", round), {{"group", group}, {"round", round}});
  writer_.begin(slot.track, now, name_at<modules::WarpActivity>(activity));
  slot.occupied = true;
  slot.group = group;
  slot.round = round;
  slot.activity = activity;
}

void Timeline::show(Unit& unit, unsigned state, std::string_view name, Cycle now) {
  if (unit.state == state) return;
  if (unit.state != kNothing) writer_.end(unit.track, now);
  if (state != kNothing) writer_.begin(unit.track, now, name);
  unit.state = state;
}

void Timeline::sample(Cycle now) {
  const bool shown = options_.window.contains(now);
  for (std::size_t i = 0; i < sms_.size(); ++i) {
    SmTracks& tracks = sms_[i];
    const Sm& sm = *gpu_.sms()[i];
    for (RtTracks& rt : tracks.rt_units) {
      if (rt.scheduler == nullptr) continue;
      const unsigned stall = rt.stalls.look(now, rt.rt->accounted(), *rt.scheduler);
      if (!shown) continue;
      // Cycles in which a warp is scheduled are one slice; an empty unit is a gap.
      constexpr unsigned kEmpty = 1 + static_cast<unsigned>(modules::Stall::empty);
      show(rt.scheduler_track, stall == kEmpty ? kNothing : stall,
           stall == 0 ? "issue" : name_at<modules::Stall>(stall - 1), now);
      for (std::size_t u = 0; u < rt.units.size(); ++u) {
        const bool busy = !rt.units[u]->idle() || rt.units[u]->busy_pipelines(now) != 0;
        show(rt.unit_tracks[u], busy ? 0 : kNothing, "busy", now);
      }
      if (rt.buffer != nullptr) {
        tracks.occupancy += static_cast<unsigned>(std::popcount(rt.buffer->warps().occupied()));
      }
    }
    if (!shown) continue;
    const bool misses = tracks.l1_cache != nullptr && tracks.l1_cache->mshr_used() != 0;
    show(tracks.l1, misses ? 1 : sm.l1().idle() ? kNothing : 0, misses ? "misses" : "busy", now);
    for (unsigned s = 0; s < tracks.slots.size(); ++s) show_slot(tracks.slots[s], *tracks.simt, s, now);
  }
  last_ = now;
  if (!shown) {
    count(now + 1, false);  // takes the counters' values before the window
    return;
  }
  for (std::size_t i = 0; i < slices_.size(); ++i) {
    const modules::L2SliceModule& slice = *gpu_.slices()[i];
    const auto* own = dynamic_cast<const modules::L2Slice*>(&slice);
    const bool misses = own != nullptr && own->mshr_used() != 0;
    show(slices_[i], misses ? 1 : slice.idle() ? kNothing : 0, misses ? "misses" : "busy", now);
  }
  for (unsigned i = 0; i < channels_.size(); ++i) {
    show(channels_[i], memory_.outstanding(i) != 0 ? 0 : kNothing, "requests", now);
  }
  begun_ = true;
  if (now + 1 - counted_ >= options_.counter_cycles) count(now + 1, true);
}

// Means over the cycles from counted_ to `end`, shown from counted_ on.
void Timeline::count(Cycle end, bool write) {
  const Cycle cycles = end - counted_;
  for (std::size_t i = 0; i < sms_.size(); ++i) {
    SmTracks& tracks = sms_[i];
    const modules::RegionCounters nodes = gpu_.sms()[i]->l1().counters().nodes();
    if (write) {
      writer_.counter(tracks.process, counted_, "RT occupancy", {{"warps", rate(tracks.occupancy, cycles)}});
      writer_.counter(tracks.process, counted_, "L1 node hit rate",
                      {{"hits", rate(nodes.hits - tracks.nodes.hits, nodes.reads - tracks.nodes.reads)}});
    }
    tracks.nodes = nodes;
    tracks.occupancy = 0;
  }
  std::uint64_t reads = 0, hits = 0;
  const std::uint64_t bytes = memory_.total().bytes;
  for (const auto& slice : gpu_.slices()) {
    const modules::RegionCounters all = slice->counters().all();
    reads += all.reads;
    hits += all.hits;
  }
  if (write) {
    writer_.counter(memory_process_, counted_, "L2 hit rate", {{"hits", rate(hits - l2_hits_, reads - l2_reads_)}});
    writer_.counter(memory_process_, counted_, "DRAM bandwidth",
                    {{"bytes per cycle", rate(bytes - dram_bytes_, cycles)}});
  }
  l2_reads_ = reads;
  l2_hits_ = hits;
  dram_bytes_ = bytes;
  counted_ = end;
}

void Timeline::finish() {
  if (begun_ && last_ + 1 > counted_) count(last_ + 1, true);
  writer_.finish(begun_ ? last_ + 1 : 0);
}

}  // namespace grtx::sim
