// SPDX-License-Identifier: Apache-2.0
// Probes of a GPU's units: the parts of an RT unit, a SIMT core, an L1, an L2 slice, a link. Each adds its wires under
// the module's name in the block diagram, and shows the module's state at the end of a cycle.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/rt_unit/any_hit_collector.h"
#include "grtx/modules/rt_unit/any_hit_unit.h"
#include "grtx/modules/rt_unit/intersection_unit.h"
#include "grtx/modules/rt_unit/memory_scheduler.h"
#include "grtx/modules/rt_unit/sibling_prefetcher.h"
#include "grtx/modules/rt_unit/warp_buffer.h"
#include "grtx/modules/rt_unit/warp_walk_scheduler.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/observe/stall_follower.h"
#include "grtx/rtl_tlm/observe/warp_probe.h"
#include "grtx/rtl_tlm/observe/wires.h"
#include "grtx/rtl_tlm/rtl/rtl_signals.h"

namespace grtx::sim {

class RtUnitProbe {
 public:
  /// User-supplied parts of the unit have no signals.
  RtUnitProbe(Wires& wires, const std::string& scope, const modules::RtUnitModule& rt, const traces::Header& header);
  void sample(Cycle now);

 private:
  void sample_any_hit(Cycle now);
  void sample_walk();

  struct Unit {
    const modules::IntersectionState* unit = nullptr;
    Wire state, busy, queued, in_flight;
  };
  /// Signals of a unit that is a Verilated block.
  struct Rtl {
    const RtlSignals* block = nullptr;
    std::vector<Wire> signals;
  };
  const modules::RtUnitModule& rt_;
  const modules::WarpBuffer* buffer_;
  const modules::WarpWalkScheduler* walk_;
  const modules::RtSchedulerState* scheduler_;
  const modules::MemoryScheduler* memory_;
  const modules::AnyHitCollector* any_hit_;
  const modules::AnyHitUnit* any_hit_unit_;
  const modules::CheckpointState* checkpoint_;
  const modules::SiblingPrefetcher* prefetcher_;
  const modules::WarpTable* warps_of_ = nullptr;
  StallFollower stalls_;
  bool selected_ = false;
  Wire issue_, stall_, occupancy_, ready_, memory_queue_, memory_outstanding_, fetches_, any_hit_waiting_,
      any_hit_at_shader_, any_hit_timer_, any_hit_batches_, any_hit_timeouts_;
  Wire walk_waiting_, walk_under_way_, walk_hits_;
  Wire heap_hits_, heap_handled_, heap_entered_;
  Wire ckpt_submitting_, ckpt_reading_, ckpt_writes_, ckpt_outstanding_, ckpt_written_, ckpt_read_;
  Wire prefetch_queue_, prefetch_outstanding_;
  std::vector<Unit> units_;
  std::vector<Rtl> rtl_;
  std::vector<WarpProbe> warps_;
};

class SimtProbe {
 public:
  SimtProbe(Wires& wires, const std::string& scope, const modules::SimtCore& simt);
  void sample();

 private:
  struct Slot {
    Wire activity, group, round;
  };
  const modules::SimtCore& simt_;
  Cycle seen_ = modules::kNever;  ///< last activity cycle that was shown
  bool selected_ = false;
  bool slots_selected_ = false;
  Wire resident_, queued_, in_flight_;
  std::array<Wire, modules::kWarpActivities> warps_;
  std::vector<Slot> slots_;
};

class L1Probe {
 public:
  L1Probe(Wires& wires, const std::string& scope, const modules::L1Cache& l1);
  void sample();

 private:
  const modules::L1Cache& l1_;
  bool selected_ = false;
  Wire state_, mshr_, misses_, writes_, fills_, stalls_;
};

class L2Probe {
 public:
  L2Probe(Wires& wires, const std::string& scope, const modules::L2Slice& slice);
  void sample();

 private:
  const modules::L2Slice& slice_;
  bool selected_ = false;
  Wire state_, mshr_, accesses_, replies_, dram_queue_, dram_outstanding_;
};

/// Shows the message that a registered link takes in a cycle. Sampling an idle link costs one comparison.
template <typename T>
class LinkProbe {
 public:
  LinkProbe(Wires& wires, const std::string& scope, const modules::Link<T>& link) : link_(link) {
    const std::size_t before = wires.selected();
    valid_ = wires.add(scope + ".valid", 1, WaveLevel::signals);
    ready_ = wires.add(scope + ".ready", 1, WaveLevel::signals);
    level_ = wires.add(scope + ".level", width_for(link.capacity()), WaveLevel::signals);
    if constexpr (requires(const T& t) { t.address; }) {
      address_ = wires.add(scope + ".address", 48, WaveLevel::signals);
    }
    if constexpr (requires(const T& t) { t.slot; }) slot_ = wires.add(scope + ".slot", 6, WaveLevel::signals);
    if constexpr (requires(const T& t) { t.lanes; }) {
      lanes_ = wires.add(scope + ".lanes", modules::kMaxLanes, WaveLevel::signals);
    }
    selected_ = wires.selected() != before;
  }
  bool selected() const { return selected_; }
  void sample(Cycle now) {
    // Nothing was sent or taken since the last sample, and `valid` is already back at 0.
    if (!valid_shown_ && link_.pushed() == pushed_ && link_.size() == size_) return;
    pushed_ = link_.pushed();
    size_ = link_.size();
    const T* sent = link_.sent(now);
    valid_shown_ = sent != nullptr;
    valid_.set(sent != nullptr);
    ready_.set(link_.can_push(now + 1));
    level_.set(size_);
    if (sent == nullptr) return;
    if constexpr (requires(const T& t) { t.address; }) address_.set(sent->address);
    if constexpr (requires(const T& t) { t.slot; }) slot_.set(sent->slot);
    if constexpr (requires(const T& t) { t.lanes; }) lanes_.set(sent->lanes);
  }

 private:
  const modules::Link<T>& link_;
  bool selected_ = false;
  bool valid_shown_ = true;  ///< true, so that the first sample shows all
  std::size_t size_ = 0;     ///< at the last sample
  std::uint64_t pushed_ = 0;
  Wire valid_, ready_, level_, address_, slot_, lanes_;
};

}  // namespace grtx::sim
