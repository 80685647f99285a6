// SPDX-License-Identifier: Apache-2.0
// Warp buffer of the RT unit: the warps whose rays are being traversed, with the state of each lane.
// Paper: Section IV-B, "Baseline Architecture" and "Hardware cost" (replay flag and buffer offsets).
// Cost: per lane ray data, stack and status; with checkpointing also 33 bits per lane and 18 bytes per unit (1074 B for
// 8 warps).
#pragma once

#include <algorithm>
#include <iosfwd>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/modules/rt_unit/stack/decide/stack_entry.h"
#include "grtx/modules/rt_unit/stack/decide/stack_spill.h"
#include "grtx/modules/rt_unit/warp_buffer/decide/warp_buffer_config.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_buffer_if.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"

namespace grtx::modules {

class WarpBuffer final : public WarpBufferModule, public Probed {
 public:
  using Config = WarpBufferConfig;
  using Counters = WarpBufferCounters;

  /// checkpoint: the trace has checkpointing, so replay flags and buffer offsets exist.
  /// stack_entry: layout of a stack entry; without bits, the stacks are in another part.
  /// objects: the trace has three levels, so the ray is also kept in object space.
  /// bvh_width: of the trace; the depth of stacks that do not spill follows from it.
  /// ray_readers: units that read rays.
  WarpBuffer(const sc_core::sc_module_name& name, const Config& config, bool checkpoint,
             const StackEntryLayout& stack_entry, bool objects = false, unsigned bvh_width = 6,
             unsigned ray_readers = 2);

  WarpTable& warps() override { return table_; }
  const WarpTable& warps() const { return table_; }

  void retire(Cycle now) override;
  void accept(Cycle now) override;
  void settle(Cycle end) override;

  bool idle() const override { return table_.empty(); }
  std::uint64_t progress() const override { return table_.counters().calls + table_.counters().warp_latency.count(); }
  Counters counters() const override { return table_.counters(); }
  Inventory inventory() const override;
  std::vector<UnitProbe> probes() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override { table_ = WarpTable(config_.entries); }

 private:
  void end_of_elaboration() override;

  Config config_;
  bool checkpoint_;
  StackEntryLayout stack_entry_;
  bool objects_;
  unsigned bvh_width_;
  unsigned ray_readers_;
  WarpTable table_;
  warp_admission_if* admission_ = nullptr;
  LinkReader<TraceCall> calls_;
  LinkWriter<TraceDone> dones_;
};

}  // namespace grtx::modules
