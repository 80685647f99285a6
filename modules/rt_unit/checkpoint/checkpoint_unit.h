// SPDX-License-Identifier: Apache-2.0
// Checkpoint unit of the RT unit: addresses, combines and writes checkpoint entries, and reads them back for replay.
// Paper: Section IV-B, "Traversal Checkpointing and Replay" and "Checkpoint and Eviction Buffer".
// Cost: address generation; optionally, beyond the paper's table, per lane one open sector for writing and one for
// reading.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/bounded_queue.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/unit_probe.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/checkpoint/checkpoint_if.h"
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_config.h"
#include "grtx/modules/rt_unit/checkpoint/decide/checkpoint_layout.h"

namespace grtx::modules {

/// State of the project's checkpoint units (SystemC and RTL) after a cycle, for observers.
class CheckpointState : public Probed {
 public:
  virtual std::size_t lanes() const = 0;  ///< of the warp buffer
  virtual std::size_t lanes_submitting() const = 0;
  virtual std::size_t lanes_reading() const = 0;                  ///< lanes with sectors to request
  virtual std::size_t writes_queued() const = 0;                  ///< sectors
  virtual std::uint64_t outstanding() const = 0;                  ///< requests sent, not answered
  virtual std::uint32_t source_offset(LaneId id) const = 0;       ///< entries read in the round
  virtual std::uint32_t destination_offset(LaneId id) const = 0;  ///< entries written in the round
  virtual CheckpointCounters counters() const = 0;
  std::vector<UnitProbe> probes() const final;

 protected:
  ~CheckpointState() = default;
};

/// Storage and operators of a checkpoint unit. lanes: number of lanes in the warp buffer. header: of the trace.
Inventory checkpoint_inventory(const char* name, const CheckpointConfig& config, std::uint64_t lanes,
                               const traces::Header& header);

class CheckpointUnit final : public CheckpointModule, public CheckpointState {
 public:
  using Config = CheckpointConfig;
  using Counters = CheckpointCounters;

  /// map: must have the same entry_bytes. header: of the trace; must outlive the unit. sm: number of the SM, which
  /// selects the per-ray buffers. Throws Error for an impossible configuration.
  CheckpointUnit(const sc_core::sc_module_name& name, const Config& config, const MemoryMap& map,
                 const traces::Header& header, unsigned entries, unsigned sm);

  void begin_lane(LaneId id, std::uint16_t slot, std::uint32_t round, bool replays, std::uint32_t source_entries,
                  const traces::Ray& ray) override;
  bool needs_source_entries() const override { return layout_.needs_source_entries(); }
  bool submit(LaneId id, unsigned entries, bool last) override;
  bool read(LaneId id) override;

  void respond(Cycle now) override;
  /// Reads have priority over writes, unless their sector is still in the write queue.
  void issue(Cycle now) override;
  /// Accepts up to Config::lanes entries, in order of submission, while the write queue has room.
  void accept(Cycle now) override;

  bool busy() const override { return !submitted_.empty() || !reads_.empty() || !writes_.empty(); }
  bool idle() const override { return !busy() && outstanding_ == 0; }
  std::uint64_t progress() const override {
    return counters_.sectors_read + counters_.sectors_written + counters_.acknowledged + counters_.returned;
  }
  std::size_t lanes() const override { return lanes_.size(); }
  std::size_t lanes_submitting() const override { return submitted_.size(); }
  std::size_t lanes_reading() const override { return reads_.size(); }
  std::size_t writes_queued() const override { return writes_.size(); }
  std::uint64_t outstanding() const override { return outstanding_; }
  std::uint32_t source_offset(LaneId id) const override { return lanes_[id].place.read; }
  std::uint32_t destination_offset(LaneId id) const override { return lanes_[id].place.written; }
  Counters counters() const override { return counters_; }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;
  void restart() override;

 private:
  struct LaneContext {
    CheckpointLayout::Lane place;
    CheckpointLayout::Sectors to_read;  ///< sectors of the entry being read
    std::uint8_t pending = 0;           ///< entries submitted, not accepted yet
    bool flush = false;                 ///< the open sectors must be written after the pending entries
    std::uint8_t reads_to_send = 0;
    std::uint8_t reads_missing = 0;
  };
  void end_of_elaboration() override;
  bool take(LaneId id, unsigned& budget);
  bool write_waits(std::uint64_t sector) const;

  Config config_;
  const MemoryMap& map_;
  const traces::Header& header_;
  checkpoint_client_if* client_ = nullptr;
  LinkWriter<MemoryRequest> requests_;
  LinkReader<MemoryResponse> responses_;
  CheckpointLayout layout_;
  unsigned sm_;
  std::vector<LaneContext> lanes_;
  BoundedQueue<LaneId> submitted_;
  BoundedQueue<LaneId> reads_;          ///< lanes with sectors to request
  BoundedQueue<std::uint64_t> writes_;  ///< sector numbers
  std::uint64_t outstanding_ = 0;
  Counters counters_;
};

}  // namespace grtx::modules
