#include "grtx/modules/rt_unit/checkpoint_unit.h"

#include <algorithm>
#include <cassert>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

namespace {

constexpr std::uint64_t kNoSector = CheckpointLayout::kNoSector;

}  // namespace

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
      layout_(order, capacity, config.write_combine, config.read_buffer),
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
  lane = {};
  lane.place = layout_.begin(map_, map_.ray_slot(sm_, slot, lane_of(id)), round, source_entries);
}

bool CheckpointUnit::submit(LaneId id, unsigned entries, bool last) {
  LaneContext& lane = lanes_[id];
  assert(lane.pending == 0 && !lane.flush);
  lane.pending = static_cast<std::uint8_t>(entries);
  lane.flush = last && config_.write_combine && (entries > 0 || layout_.open_sector(lane.place) != kNoSector);
  if (lane.pending == 0 && !lane.flush) return false;
  submitted_.push(id);
  return true;
}

// Hands over as much of the lane as budget and room allow; true when nothing is left. One entry completes at most one
// sector when combining (20 B < 32 B), and touches at most two.
bool CheckpointUnit::take(LaneId id, unsigned& budget) {
  LaneContext& lane = lanes_[id];
  while (lane.pending > 0) {
    if (budget == 0 || writes_.room() < layout_.most_sectors()) return false;
    const CheckpointLayout::Sectors sectors = layout_.write(lane.place);
    for (unsigned i = 0; i < sectors.count; ++i) writes_.push(sectors.number[i]);
    if (sectors.straddles) ++counters_.straddling_written;
    ++counters_.entries_written;
    counters_.max_entries = std::max<std::uint64_t>(counters_.max_entries, lane.place.written);
    --lane.pending;
    --budget;
  }
  if (lane.flush) {
    if (const std::uint64_t open = layout_.open_sector(lane.place); open != kNoSector) {
      if (budget == 0 || writes_.room() == 0) return false;
      writes_.push(open);
      --budget;
    }
    lane.flush = false;
  }
  return true;
}

bool CheckpointUnit::read(LaneId id) {
  LaneContext& lane = lanes_[id];
  assert(lane.reads_missing == 0);
  lane.to_read = layout_.read(lane.place);
  ++counters_.entries_read;
  if (lane.to_read.straddles) ++counters_.straddling_read;
  if (lane.to_read.count == 0) return true;
  lane.reads_to_send = lane.reads_missing = static_cast<std::uint8_t>(lane.to_read.count);
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
    const std::uint64_t sector = lane.to_read.number[lane.to_read.count - lane.reads_to_send];
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
