// Checkpoint unit of the RT unit: addresses, combines and writes checkpoint entries, and reads them back for replay.
// Paper: Section IV-B, "Traversal Checkpointing and Replay" and "Checkpoint and Eviction Buffer".
// Cost: address generation; beyond the paper's table, one open sector a lane for writing and one for reading
// (switches).
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <systemc>
#include <vector>

#include "grtx/modules/kernel/bounded_queue.h"
#include "grtx/modules/kernel/counter_table.h"
#include "grtx/modules/kernel/inventory.h"
#include "grtx/modules/kernel/link_access.h"
#include "grtx/modules/kernel/parameter.h"
#include "grtx/modules/kernel/statistics.h"
#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/messages/memory_map.h"
#include "grtx/modules/messages/memory_request.h"
#include "grtx/modules/rt_unit/checkpoint_if.h"
#include "grtx/modules/rt_unit/checkpoint_layout.h"

namespace grtx::modules {

class CheckpointUnit final : public CheckpointModule {
 public:
  struct Config {
    unsigned lanes = 4;  ///< or last sectors
    unsigned write_queue = 16;
    bool write_combine = true;  ///< else each entry writes every sector it touches
    bool read_buffer = true;    ///< else each entry reads every sector it touches
    void parameters(ParameterList& list) {
      list.add("lanes", lanes, {1, 64}, "entries/cycle", "checkpoint entries taken from lanes in a cycle", kOurs);
      list.add("write_queue", write_queue, {2, kMaxEntries}, "sectors", "checkpoint sectors waiting to be written",
               kOurs);
      list.add("write_combine", write_combine, "a lane's entries gather in its open sector before they are written",
               kOurs);
      list.add("read_buffer", read_buffer, "a lane keeps the last sector it replayed", kOurs);
    }
  };
  struct Counters {
    std::uint64_t entries_written = 0;
    std::uint64_t entries_read = 0;
    std::uint64_t sectors_written = 0;
    std::uint64_t sectors_read = 0;
    std::uint64_t acknowledged = 0;        ///< write responses
    std::uint64_t returned = 0;            ///< read responses
    std::uint64_t straddling_written = 0;  ///< entries that lie in two sectors
    std::uint64_t straddling_read = 0;
    std::uint64_t max_entries = 0;     ///< most entries a lane wrote in a round
    std::uint64_t blocked_cycles = 0;  ///< cycles in which lanes were left waiting for the write queue
    static const CounterTable<Counters>& table();
    void add(const Counters& other) { table().add(*this, other); }
    void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
  };

  /// order: the trace's checkpoint_order. capacity: entries of a buffer. sm: whose per-ray buffers are addressed.
  CheckpointUnit(const sc_core::sc_module_name& name, const Config& config, const MemoryMap& map,
                 traces::CheckpointOrder order, std::uint64_t capacity, unsigned entries, unsigned sm);

  void begin_lane(LaneId id, std::uint16_t slot, std::uint32_t round, std::uint32_t source_entries) override;
  bool reads_backwards() const override { return layout_.reads_backwards(); }
  bool submit(LaneId id, unsigned entries, bool last) override;
  bool read(LaneId id) override;

  void respond(Cycle now) override;
  /// Reads go first, unless their sector still waits in the write queue.
  void issue(Cycle now) override;
  /// Takes up to `lanes` entries, lanes in order of submission, while the write queue has room.
  void accept(Cycle now) override;

  bool busy() const override { return !submitted_.empty() || !reads_.empty() || !writes_.empty(); }
  bool idle() const override { return !busy() && outstanding_ == 0; }
  std::uint64_t progress() const override {
    return counters_.sectors_read + counters_.sectors_written + counters_.acknowledged + counters_.returned;
  }
  void count(RtUnitCounters& all) const override;
  std::size_t lanes_submitting() const { return submitted_.size(); }
  std::size_t lanes_reading() const { return reads_.size(); }                     ///< with sectors to request
  std::size_t writes_queued() const { return writes_.size(); }                    ///< sectors
  std::uint64_t outstanding() const { return outstanding_; }                      ///< requests sent, not answered
  std::uint32_t source_offset(LaneId id) const { return lanes_[id].place.read; }  ///< entries read in the round
  /// Entries written in the round.
  std::uint32_t destination_offset(LaneId id) const { return lanes_[id].place.written; }
  const Counters& counters() const { return counters_; }
  Inventory inventory() const override;
  void dump_state(std::ostream& out) const override;

 private:
  struct LaneContext {
    CheckpointLayout::Lane place;
    CheckpointLayout::Sectors to_read;  ///< of the entry being read
    std::uint8_t pending = 0;           ///< entries submitted, not taken
    bool flush = false;                 ///< the open sector must be written after them
    std::uint8_t reads_to_send = 0;
    std::uint8_t reads_missing = 0;
  };
  void end_of_elaboration() override;
  bool take(LaneId id, unsigned& budget);
  bool write_waits(std::uint64_t sector) const;

  Config config_;
  const MemoryMap& map_;
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
