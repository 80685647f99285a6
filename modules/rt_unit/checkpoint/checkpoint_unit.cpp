// SPDX-License-Identifier: Apache-2.0
#include "grtx/modules/rt_unit/checkpoint/checkpoint_unit.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <numeric>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/make_anew.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

namespace {

using traces::kBinNumberBits;

/// Adds the hardware for bins: per lane the heads, tails and readable entries of each ring, and the open sectors. The
/// bin number is taken from the bits of a distance.
void add_bins(const CheckpointConfig& config, std::uint64_t lanes, const traces::Header& header, Inventory& inventory) {
  const unsigned bins = traces::CheckpointBins::rings_of(header.checkpoint_bins);
  const unsigned bin_bits = static_cast<unsigned>(std::bit_width(bins - 1));
  const unsigned place_bits = static_cast<unsigned>(std::bit_width(header.checkpoint_capacity));
  const unsigned pointers = 3 * place_bits;
  inventory.storage.push_back({"bin_pointers", StorageKind::ram, lanes * bins * pointers, 1, 1, false, pointers});
  // Distance at which the ray enters the scene, number of the round's first bin, bins passed since, and the bin number
  // from which on the far bin is used.
  const unsigned read_bits = 32 + 2 * kBinNumberBits + bin_bits;
  inventory.storage.push_back({"bin_read", StorageKind::ram, lanes * read_bits, 1, 1, false, read_bits});
  if (config.write_combine) {
    const unsigned tag_bits = bin_bits + place_bits;
    inventory.storage.push_back(
        {"open_tags", StorageKind::ram, lanes * config.open_sectors * tag_bits, 1, 1, false, tag_bits});
    inventory.operators.push_back({"match", tag_bits, std::uint64_t{config.lanes} * config.open_sectors});
  }
  // Selects the next bin with entries to read and compares its number with that of t_max; for each entry accepted in a
  // cycle selects a ring with room, which is rarely not its own.
  inventory.operators.push_back({"fp_add", 32, config.lanes + 1ull});  // distances of entries and of t_max
  inventory.operators.push_back({"int_add", kBinNumberBits, 1});
  inventory.operators.push_back({"int_compare", kBinNumberBits, 1});
  inventory.operators.push_back({"int_compare", place_bits, bins * (config.lanes + 1ull)});
}

}  // namespace

const CounterTable<CheckpointCounters>& CheckpointCounters::table() {
  using C = CheckpointCounters;
  static const CounterTable<C> table =
      CounterTable<C>()
          .exact(&C::entries_written, "entries_written", "entries", "checkpoint entries written to destination buffers")
          .exact(&C::entries_read, "entries_read", "entries", "checkpoint entries read from source buffers")
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
                               const traces::Header& header, unsigned entries, unsigned sm)
    : CheckpointModule(name),
      config_(config),
      map_(map),
      header_(header),
      layout_(config, header),
      sm_(sm),
      lanes_(std::size_t{entries} * kMaxLanes),
      submitted_(std::size_t{entries} * kMaxLanes),
      reads_(std::size_t{entries} * kMaxLanes),
      writes_(config.write_queue > 0 ? config.write_queue : 1) {
  require_allowed("rt.checkpoint", config);
  if (map.checkpoint_entry_bytes() != config.entry_bytes) {
    throw Error("configuration", "rt.checkpoint.entry_bytes", "must be those of the memory map");
  }
}

void CheckpointUnit::end_of_elaboration() {
  client_ = client.operator->();
  requests_ = writer_of(request);
  responses_ = reader_of(response);
}

void CheckpointUnit::restart() {
  make_anew(layout_, config_, header_);
  std::fill(lanes_.begin(), lanes_.end(), LaneContext());
  submitted_.clear();
  reads_.clear();
  writes_.clear();
  awake_ = false;
  outstanding_ = 0;
  counters_ = {};
}

void CheckpointUnit::begin_lane(LaneId id, std::uint16_t slot, std::uint32_t round, bool replays,
                                std::uint32_t source_entries, const traces::Ray& ray) {
  LaneContext& lane = lanes_[id];
  assert(lane.pending == 0 && !lane.flush && lane.reads_missing == 0);
  lane = {};
  lane.place = layout_.begin(map_, sm_, slot, lane_of(id), round, replays, source_entries, ray);
}

bool CheckpointUnit::submit(LaneId id, unsigned entries, bool last) {
  LaneContext& lane = lanes_[id];
  assert(lane.pending == 0 && !lane.flush);
  if (entries == 0 && !last) return false;  // most events
  layout_.submit(lane.place, entries);
  lane.pending = static_cast<std::uint8_t>(entries);
  counters_.max_entries = std::max<std::uint64_t>(counters_.max_entries, lane.place.written);
  lane.flush = last && config_.write_combine && (lane.pending > 0 || layout_.has_open_sector(lane.place));
  if (lane.pending == 0 && !lane.flush) return false;
  submitted_.push(id);
  awake_ = true;
  return true;
}

// Accepts as many of the lane's items (entries or open sectors) as budget and queue room allow. Returns true if none is
// left. An item writes at most one sector when combining, else all that it touches, at most two.
bool CheckpointUnit::take(LaneId id, unsigned& budget) {
  LaneContext& lane = lanes_[id];
  while (lane.pending > 0) {
    if (budget == 0 || writes_.room() < layout_.most_sectors()) return false;
    const CheckpointLayout::Sectors sectors = layout_.append(lane.place);
    for (unsigned i = 0; i < sectors.count; ++i) writes_.push(sectors.number[i]);
    if (sectors.straddles) ++counters_.straddling_written;
    ++counters_.entries_written;
    --lane.pending;
    --budget;
  }
  while (lane.flush && layout_.has_open_sector(lane.place)) {
    if (budget == 0 || writes_.room() == 0) return false;
    writes_.push(layout_.close_sector(lane.place));
    --budget;
  }
  lane.flush = false;
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
  awake_ = true;
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
  const MemoryResponse* answer = responses_.front(now);
  if (answer == nullptr) return;
  const bool write = answer->write;
  const auto id = static_cast<LaneId>(answer->tag);
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
  if (submitted_.empty()) {
    awake_ = busy();
    return;
  }
  unsigned budget = config_.lanes;
  while (!submitted_.empty() && take(submitted_.front(), budget)) {
    const LaneId id = submitted_.front();
    submitted_.pop();
    client_->entries_taken(id);
  }
  if (!submitted_.empty()) ++counters_.blocked_cycles;
}

std::vector<UnitProbe> CheckpointState::probes() const {
  const auto width = static_cast<unsigned>(std::bit_width(lanes()));
  return {{"lanes_submitting", width, [this] { return lanes_submitting(); }},
          {"lanes_reading", width, [this] { return lanes_reading(); }},
          {"writes_queued", kLevelBits, [this] { return writes_queued(); }},
          {"outstanding", kLevelBits, [this] { return outstanding(); }},
          {"entries_written", kCounterBits, [this] { return counters().entries_written; }},
          {"entries_read", kCounterBits, [this] { return counters().entries_read; }}};
}

Inventory CheckpointUnit::inventory() const { return checkpoint_inventory(name(), config_, lanes_.size(), header_); }

Inventory checkpoint_inventory(const char* name, const CheckpointConfig& config, std::uint64_t lanes,
                               const traces::Header& header) {
  Inventory inventory{name, {}, {}};
  auto& storage = inventory.storage;
  const std::uint64_t sector_bits = kSectorBytes * 8;
  storage.push_back({"write_queue", StorageKind::ram, config.write_queue * (sector_bits + kSectorBytes + 48), 1, 1,
                     false, static_cast<unsigned>(sector_bits) + kSectorBytes + 48});
  storage.push_back({"submitted", StorageKind::ram, lanes * 8, 1, 1, false, 8});
  storage.push_back({"reads", StorageKind::ram, lanes * 8, 1, 1, false, 8});
  // Not in the paper's table, which does not say how entries become memory requests.
  const unsigned entry_bits = config.entry_bytes * 8;
  if (config.write_combine)
    storage.push_back(
        {"open_sectors", StorageKind::ram, lanes * config.open_sectors * sector_bits, 1, 1, false, entry_bits});
  if (config.read_buffer)
    storage.push_back({"read_sectors", StorageKind::ram, lanes * sector_bits, 1, 1, false, entry_bits});
  if (header.checkpoint_bins != 0) add_bins(config, lanes, header, inventory);
  // Heads and levels of the ray queues; head, level and full bits of the write queue; outstanding requests; whether the
  // first of two sectors has been sent; one bit per ray: two responses missing (checkpoint_unit.sv).
  const unsigned ray_bits = static_cast<unsigned>(std::bit_width(lanes - 1));
  const auto places = config.write_queue;
  const std::uint64_t control = 2ull * (2 * ray_bits + 1) + static_cast<unsigned>(std::bit_width(places - 1)) +
                                static_cast<unsigned>(std::bit_width(places)) + places + 16 + 1 + lanes;
  storage.push_back({"control", StorageKind::flip_flop, control});
  auto& operators = inventory.operators;
  operators.push_back({"fp_compare", 32, 2ull * config.lanes});  // t-value validation: t_hit against t_min, t_max
  // offset x 20 = x 16 + x 4; powers of two are wires.
  // One for the source and one for the destination entry of each lane; the RTL has three more: for a read, its result
  // and the end of a submission.
  if (!std::has_single_bit(config.entry_bytes)) operators.push_back({"mul_constant", 16, 2ull * config.lanes + 3});
  operators.push_back({"int_add", 64, 2ull * config.lanes});  // base + slot offset + entry offset
  // Converts between BLAS header addresses and their numbers.
  if (config.entry_bytes == 8 && header.two_level) operators.push_back({"int_add", 64, 2ull * config.lanes});
  operators.push_back({"increment", 16, 2ull * config.lanes});    // source and destination offset
  operators.push_back({"int_compare", 16, 2ull * config.lanes});  // against the maximum size
  // Further hardware of the RTL (docs/results/rtl.md). An entry begins at any multiple of the greatest common divisor
  // of its size and the sector size: writes shift it and its byte mask into place, reads shift it back.
  const unsigned positions =
      static_cast<unsigned>(kSectorBytes) / std::gcd(config.entry_bytes, static_cast<unsigned>(kSectorBytes));
  const unsigned shifts = static_cast<unsigned>(std::bit_width(positions - 1));
  operators.push_back({"mux", entry_bits + config.entry_bytes, shifts * (config.lanes + 1ull)});
  operators.push_back({"match", 48, places});  // a read waits for a write of its sector
  operators.push_back({"mux", 48, 2});         // a request is a read or a write
  operators.push_back({"mux", 1, 5 * lanes});  // set, clear and read the bit of each ray
  operators.push_back({"increment", static_cast<unsigned>(control - lanes - places), 1});
  return inventory;
}

void CheckpointUnit::dump_state(std::ostream& out) const {
  out << name() << ": " << submitted_.size() << " lanes handing over, " << reads_.size() << " lanes to read, "
      << writes_.size() << " sectors to write, " << outstanding_ << " requests outstanding\n";
}

PartInfo part_info(const CheckpointConfig& config) {
  PartInfo part;
  part.name = "checkpoint_unit";
  part.title = "checkpoint unit";
  part.statistics = {"gpu.rt.checkpoint.", "gpu.rt.replay_"};
  part.keys = {"rt.checkpoint."};
  std::vector<EnergyTerm> terms = {uses("fp_compare", 32, 2.0), uses("int_add", 64)};
  if (!std::has_single_bit(config.entry_bytes)) terms.push_back(uses("mul_constant", 16));
  for (const EnergyTerm& term : {uses("increment", 16), uses("int_compare", 16),
                                 writes("checkpoint_unit", "open_sectors"), reads("checkpoint_unit", "bin_pointers"),
                                 writes("checkpoint_unit", "bin_pointers"), reads("checkpoint_unit", "bin_read")}) {
    terms.push_back(term);
  }
  part.energy = {{.name = "rt.checkpoint_unit",
                  .statistics = {"gpu.rt.checkpoint.entries_written", "gpu.rt.checkpoint.entries_read"},
                  .terms = terms,
                  .basis = "entries written and read"}};
  part.stalls = {{"checkpoint", "checkpoint entries"}};
  return part;
}

}  // namespace grtx::modules
