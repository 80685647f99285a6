#include "grtx/modules/rt_unit/checkpoint_unit.h"

#include <algorithm>
#include <cassert>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

using traces::kCheckpointEntryBytes;

const CounterTable<CheckpointUnit::Counters>& CheckpointUnit::Counters::table() {
  using C = CheckpointUnit::Counters;
  static const CounterTable<C> table =
      CounterTable<C>()

          .sum(&C::entries_written, "entries_written", "entries", "checkpoint entries written to destination buffers")
          .sum(&C::entries_read, "entries_read", "entries", "checkpoint entries read from source buffers")
          .sum(&C::sectors_written, "sectors_written", "requests", "32 B writes of checkpoint buffers")
          .sum(&C::sectors_read, "sectors_read", "requests", "32 B reads of checkpoint buffers")
          .sum(&C::straddling_written, "straddling_written", "entries", "written entries that lie in two sectors")
          .sum(&C::straddling_read, "straddling_read", "entries", "read entries that lie in two sectors")
          .largest(&C::max_entries, "max_entries", "entries", "most entries one lane wrote in one round")
          .sum(&C::blocked_cycles, "blocked_cycles", "cycles", "cycles in which lanes waited to hand over entries")
          .sum(&C::acknowledged)
          .sum(&C::returned);
  return table;
}

CheckpointUnit::CheckpointUnit(const sc_core::sc_module_name& name, const Config& config, const MemoryMap& map,
                               traces::CheckpointOrder order, std::uint64_t capacity, unsigned entries, unsigned sm)
    : CheckpointModule(name),
      config_(config),
      map_(map),
      lifo_(order == traces::CheckpointOrder::lifo),
      capacity_(capacity),
      sm_(sm),
      lanes_(std::size_t{entries} * kMaxLanes),
      submitted_(std::size_t{entries} * kMaxLanes),
      reads_(std::size_t{entries} * kMaxLanes),
      writes_(config.write_queue > 0 ? config.write_queue : 1) {
  require_allowed("rt.checkpoint", config);
}

void CheckpointUnit::end_of_elaboration() {
  client_ = client.operator->();
  requests_ = writer_of(request);
  responses_ = reader_of(response);
}

void CheckpointUnit::begin_lane(LaneId id, std::uint16_t slot, std::uint32_t round, std::uint32_t source_entries) {
  LaneContext& lane = lanes_[id];
  assert(lane.pending == 0 && !lane.flush && lane.reads_missing == 0);
  const std::uint64_t ray = map_.ray_slot(sm_, slot, lane_of(id));
  lane = {};
  lane.destination = map_.checkpoint_entry(ray, round & 1, 0);
  lane.source = map_.checkpoint_entry(ray, (round & 1) ^ 1, 0);
  lane.source_entries = source_entries;
}

// Something of the last entry lies in a sector that has not been written.
bool CheckpointUnit::open_sector(const LaneContext& lane) const {
  return config_.write_combine && lane.written > 0 &&
         (lane.destination + lane.written * kCheckpointEntryBytes) % kSectorBytes != 0;
}

bool CheckpointUnit::submit(LaneId id, unsigned entries, bool last) {
  LaneContext& lane = lanes_[id];
  assert(lane.pending == 0 && !lane.flush);
  lane.pending = static_cast<std::uint8_t>(entries);
  lane.flush = last && config_.write_combine && (entries > 0 || open_sector(lane));
  if (lane.pending == 0 && !lane.flush) return false;
  submitted_.push(id);
  return true;
}

// Hands over as much of the lane as budget and room allow; true when nothing is left. One entry completes at most one
// sector when combining (20 B < 32 B), and touches at most two.
bool CheckpointUnit::take(LaneId id, unsigned& budget) {
  LaneContext& lane = lanes_[id];
  const std::size_t need = config_.write_combine ? 1 : 2;
  while (lane.pending > 0) {
    if (budget == 0 || writes_.room() < need) return false;
    if (lane.written >= capacity_) {
      throw Error("trace", "checkpoint buffer", "a ray writes more entries than the header's checkpoint_capacity");
    }
    const std::uint64_t begin = lane.destination + lane.written * kCheckpointEntryBytes;
    const std::uint64_t end = begin + kCheckpointEntryBytes;
    const std::uint64_t first = begin / kSectorBytes;
    const std::uint64_t last = (end - 1) / kSectorBytes;
    if (config_.write_combine) {
      if (first != last || end % kSectorBytes == 0) writes_.push(first);
    } else {
      writes_.push(first);
      if (first != last) writes_.push(last);
    }
    if (first != last) ++counters_.straddling_written;
    ++counters_.entries_written;
    ++lane.written;
    if (lane.written > counters_.max_entries) counters_.max_entries = lane.written;
    --lane.pending;
    --budget;
  }
  if (lane.flush) {
    if (open_sector(lane)) {
      if (budget == 0 || writes_.room() == 0) return false;
      writes_.push((lane.destination + lane.written * kCheckpointEntryBytes) / kSectorBytes);
      --budget;
    }
    lane.flush = false;
  }
  return true;
}

bool CheckpointUnit::read(LaneId id) {
  LaneContext& lane = lanes_[id];
  assert(lane.reads_missing == 0);
  const std::uint64_t index = lifo_ ? lane.source_entries - 1 - lane.read : lane.read;
  if (index >= capacity_) {
    throw Error("trace", "checkpoint buffer", "a ray reads more entries than the header's checkpoint_capacity");
  }
  ++lane.read;
  ++counters_.entries_read;
  const std::uint64_t begin = lane.source + index * kCheckpointEntryBytes;
  const std::uint64_t first = begin / kSectorBytes;
  const std::uint64_t last = (begin + kCheckpointEntryBytes - 1) / kSectorBytes;
  if (first != last) ++counters_.straddling_read;
  // The sector that the next entry shares is read last and stays.
  const std::uint64_t order[2] = {lifo_ ? last : first, lifo_ ? first : last};
  const unsigned sectors = first == last ? 1 : 2;
  unsigned count = 0;
  for (unsigned i = 0; i < sectors; ++i) {
    if (order[i] != lane.held) lane.to_read[count++] = order[i];
  }
  if (config_.read_buffer) lane.held = order[sectors - 1];
  if (count == 0) return true;
  if (count == 1) lane.to_read[1] = lane.to_read[0];  // sent from the end of the list
  lane.reads_to_send = lane.reads_missing = static_cast<std::uint8_t>(count);
  reads_.push(id);
  return false;
}

bool CheckpointUnit::write_waits(std::uint64_t sector) const {
  for (std::size_t i = 0; i < writes_.size(); ++i) {
    if (writes_.at(i) == sector) return true;
  }
  return false;
}

void CheckpointUnit::issue(Cycle now) {
  if ((reads_.empty() && writes_.empty()) || !requests_.can_push(now)) return;
  MemoryRequest message;
  message.region = Region::checkpoint;
  if (!reads_.empty()) {
    LaneContext& lane = lanes_[reads_.front()];
    const std::uint64_t sector = lane.to_read[2 - lane.reads_to_send];
    if (!write_waits(sector)) {
      message.address = sector * kSectorBytes;
      message.tag = reads_.front();
      requests_.push(now, message);
      ++counters_.sectors_read;
      ++outstanding_;
      if (--lane.reads_to_send == 0) reads_.pop();
      return;
    }
  }
  message.address = writes_.front() * kSectorBytes;
  message.write = true;
  requests_.push(now, message);
  writes_.pop();
  ++counters_.sectors_written;
  ++outstanding_;
}

void CheckpointUnit::respond(Cycle now) {
  const MemoryResponse* arrived = responses_.front(now);
  if (arrived == nullptr) return;
  const bool write = arrived->write;
  const auto id = static_cast<LaneId>(arrived->tag);
  responses_.pop(now);
  assert(outstanding_ > 0);
  --outstanding_;
  if (write) {
    ++counters_.acknowledged;
    return;
  }
  ++counters_.returned;
  LaneContext& lane = lanes_[id];
  assert(lane.reads_missing > 0);
  if (--lane.reads_missing == 0) client_->entry_read(id);
}

void CheckpointUnit::accept(Cycle) {
  if (submitted_.empty()) return;
  unsigned budget = config_.lanes;
  while (!submitted_.empty() && take(submitted_.front(), budget)) {
    const LaneId id = submitted_.front();
    submitted_.pop();
    client_->entries_taken(id);
  }
  if (!submitted_.empty()) ++counters_.blocked_cycles;
}

void CheckpointUnit::count(RtUnitCounters& all) const { all.checkpoint.add(counters_); }

Inventory CheckpointUnit::inventory() const {
  Inventory inventory{name(), {}, {}};
  auto& storage = inventory.storage;
  const std::uint64_t sector_bits = kSectorBytes * 8;
  storage.push_back({"write_queue", StorageKind::ram, config_.write_queue * (sector_bits + kSectorBytes + 48), 1, 1,
                     false, static_cast<unsigned>(sector_bits) + kSectorBytes + 48});
  storage.push_back({"submitted", StorageKind::ram, lanes_.size() * 8, 1, 1, false, 8});
  storage.push_back({"reads", StorageKind::ram, lanes_.size() * 8, 1, 1, false, 8});
  // Not in the paper's table: it does not say how 20 B entries become memory requests.
  if (config_.write_combine)
    storage.push_back({"open_sectors", StorageKind::ram, lanes_.size() * sector_bits, 1, 1, false, 160});
  if (config_.read_buffer)
    storage.push_back({"read_sectors", StorageKind::ram, lanes_.size() * sector_bits, 1, 1, false, 160});
  auto& operators = inventory.operators;
  operators.push_back({"fp_compare", 32, 2ull * config_.lanes});    // t-value validation: t_hit against t_min, t_max
  operators.push_back({"mul_constant", 16, 2ull * config_.lanes});  // offset x 20
  operators.push_back({"int_add", 64, 2ull * config_.lanes});       // base + slot offset + entry offset
  operators.push_back({"increment", 16, 2ull * config_.lanes});     // source and destination offset
  operators.push_back({"int_compare", 16, 2ull * config_.lanes});   // against the maximum size
  return inventory;
}

void CheckpointUnit::dump_state(std::ostream& out) const {
  out << name() << ": " << submitted_.size() << " lanes handing over, " << reads_.size() << " lanes to read, "
      << writes_.size() << " sectors to write, " << outstanding_ << " requests outstanding\n";
}

}  // namespace grtx::modules
