// SPDX-License-Identifier: Apache-2.0
// Timeline of a run for ui.perfetto.dev: a track for each warp slot (the warp, its rounds, what it does) and for each
// unit (when it works, why the RT scheduler stalls), and counters of occupancy, hit rate and bandwidth.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/rt_unit/intersection/intersection_unit.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/gpu/memory_system.h"
#include "grtx/rtl_tlm/observe/observation.h"
#include "grtx/rtl_tlm/observe/observe_options.h"
#include "grtx/rtl_tlm/observe/stall_follower.h"
#include "grtx/rtl_tlm/observe/trace_event_writer.h"

namespace grtx::sim {

class Timeline final : private CycleObserver {
 public:
  /// Build after the GPU. trace_hash, config_hash: kept in the file.
  Timeline(const TimelineOptions& options, Gpu& gpu, const MemorySystem& memory, const std::string& trace_hash,
           const std::string& config_hash);
  void finish();
  /// The exception that writing threw during the run, if any.
  const std::exception_ptr& failure() const { return observation_.failure(); }

 private:
  using Track = TraceEventWriter::Track;
  static constexpr unsigned kNothing = ~0u;

  /// Open slices on a warp slot's track: the warp, inside the warp a round, inside the round an activity.
  struct Slot {
    Track track = 0;
    bool occupied = false;
    std::uint32_t group = 0;
    std::uint32_t round = 0;
    unsigned activity = kNothing;
  };
  /// A track of consecutive slices, one for each state; kNothing leaves a gap.
  struct Unit {
    Track track = 0;
    unsigned state = kNothing;
    std::string name;
  };
  struct RtTracks {
    const modules::RtUnitModule* rt = nullptr;
    StallFollower stalls;
    const modules::RtSchedulerState* scheduler = nullptr;
    const modules::WarpBuffer* buffer = nullptr;
    Unit scheduler_track;
    std::vector<const modules::IntersectionState*> units;
    std::vector<Unit> unit_tracks;
  };
  struct SmTracks {
    unsigned process = 0;
    std::vector<Slot> slots;
    std::vector<RtTracks> rt_units;
    const modules::SimtCore* simt = nullptr;  ///< null: user-supplied; l1_cache alike
    const modules::L1Cache* l1_cache = nullptr;
    Unit l1;
    modules::RegionCounters nodes;  ///< at the last value of the counters
    std::uint64_t occupancy = 0;    ///< warps x cycles since then
  };

  void sample(Cycle now) override;
  void show_slot(Slot& slot, const modules::SimtCore& simt, unsigned index, Cycle now);
  void show(Unit& unit, unsigned state, std::string_view name, Cycle now);
  void count(Cycle end, bool write);

  TimelineOptions options_;
  Gpu& gpu_;
  const MemorySystem& memory_;
  TraceEventWriter writer_;
  std::vector<SmTracks> sms_;
  unsigned memory_process_ = 0;
  std::vector<Unit> slices_;
  std::vector<Unit> channels_;
  std::uint64_t l2_reads_ = 0, l2_hits_ = 0, dram_bytes_ = 0;  ///< at the last value of the counters
  Cycle counted_ = 0;                                          ///< first cycle after that value
  Cycle last_ = 0;
  bool begun_ = false;
  Observation observation_;
};

}  // namespace grtx::sim
