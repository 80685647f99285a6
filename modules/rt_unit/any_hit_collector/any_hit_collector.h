// SPDX-License-Identifier: Apache-2.0
// Any-hit collector of the RT unit: gathers the lanes of a warp that have a hit into one invocation of the any-hit
// shader. Paper, Section IV-B: invoked "when all active rays in a warp hit a primitive or a timeout occurs". Cost: one
// timer per warp.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/modules/messages/warp_messages.h"
#include "grtx/modules/rt_unit/any_hit_collector/any_hit_if.h"
#include "grtx/modules/rt_unit/any_hit_collector/decide/any_hit_collector_config.h"
#include "grtx/modules/rt_unit/any_hit_collector/decide/any_hit_firing.h"
#include "grtx/modules/rt_unit/warp_buffer/warp_table.h"

namespace grtx::modules {

class AnyHitCollector final : public AnyHitModule, public Probed {
 public:
  using Config = AnyHitCollectorConfig;
  using Counters = AnyHitCounters;

  /// entries: warps of the warp buffer.
  /// names_instances: batches have the instance leaves of hits, by which the shader finds records.
  AnyHitCollector(const sc_core::sc_module_name& name, const Config& config, unsigned entries,
                  bool names_instances = false);

  void arrive(Cycle now, LaneId id) override;
  void finished(unsigned entry) override;
  /// Sends the batch of the oldest warp that is due (all lanes hit, or timeout). One batch per warp is at the shader.
  void invoke(Cycle now) override;
  Cycle next_due(Cycle now) const override {
    return candidates_ == 0 ? kNever : firing_.earliest(*buffer_, candidates_, now);
  }

  WarpMask candidates() const { return candidates_; }  ///< entries with waiting lanes and no batch at the shader
  Counters counters() const override { return counters_; }
  bool idle() const override { return true; }  // no state of its own: waiting lanes are in the warp buffer
  std::uint64_t progress() const override { return counters_.batches; }
  Inventory inventory() const override;
  std::vector<UnitProbe> probes() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override {
    candidates_ = 0;
    awake_ = false;
    counters_ = {};
  }

 private:
  void end_of_elaboration() override;
  void fire_oldest(Cycle now);
  void become_candidate(unsigned entry) {
    candidates_ |= bit(entry);
    awake_ = true;
  }
  std::uint64_t lanes_in(LaneState state) const;
  Cycle longest_wait(Cycle now) const;
  Config config_;
  AnyHitFiring firing_;
  unsigned entries_;
  bool names_instances_;
  WarpTable* buffer_ = nullptr;
  any_hit_client_if* client_ = nullptr;
  LinkWriter<AnyHitBatch> batches_;
  LinkReader<AnyHitDone> dones_;
  WarpMask candidates_ = 0;  ///< entries with a waiting lane and no batch at the shader
  Counters counters_;
};

}  // namespace grtx::modules
