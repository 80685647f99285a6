// SPDX-License-Identifier: Apache-2.0
// Probes of a GPU's units: the parts of an RT unit, a SIMT core, an L1, an L2 slice, a link. Each adds its wires under
// the module's name in the block diagram, and shows the module's state at the end of a cycle.
#pragma once

#include <array>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "grtx/modules/cache/l1_cache.h"
#include "grtx/modules/cache/l2_slice.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/modules/rt_unit/scheduler/scheduler_base.h"
#include "grtx/modules/simt/simt_core.h"
#include "grtx/rtl_tlm/gpu/gpu.h"
#include "grtx/rtl_tlm/observe/stall_follower.h"
#include "grtx/rtl_tlm/observe/warp_probe.h"
#include "grtx/rtl_tlm/observe/wires.h"
#include "grtx/rtl_tlm/rtl/rtl_signals.h"

namespace grtx::sim {

class RtUnitProbe {
 public:
  /// Signals of the parts in the table, as far as they are Probed, and of the warps in our own warp buffer.
  RtUnitProbe(Wires& wires, const std::string& scope, const modules::RtUnitModule& rt, const traces::Header& header);
  void sample(Cycle now);
  bool shows(const modules::Probed& part) const { return parts_.contains(&part); }

 private:
  /// Signals of a unit that is a Verilated block.
  struct Rtl {
    const RtlSignals* block = nullptr;
    std::vector<Wire> signals;
  };
  void add_probes(Wires& wires, const std::string& unit, const modules::Probed* part);

  const modules::RtUnitModule& rt_;
  const modules::RtSchedulerState* scheduler_ = nullptr;
  StallFollower stalls_;
  bool selected_ = false;
  Wire issue_, stall_;
  std::set<const modules::Probed*> parts_;
  std::vector<std::pair<modules::UnitProbe, Wire>> probes_;
  std::vector<Rtl> rtl_;
  std::vector<WarpProbe> warps_;
};

/// Adds the wire of a unit's own probe below its name.
Wire add_probe(Wires& wires, const std::string& unit, const modules::UnitProbe& probe);

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
