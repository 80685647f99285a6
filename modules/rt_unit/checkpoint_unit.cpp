#include "grtx/modules/rt_unit/checkpoint_unit.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <numeric>
#include <ostream>

#include "grtx/base/error.h"
#include "grtx/modules/kernel/make_anew.h"
#include "grtx/modules/rt_unit/rt_unit_counters.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

namespace {

constexpr std::uint64_t kNoSector = CheckpointLayout::kNoSector;

}  // namespace

const CounterTable<CheckpointCounters>& CheckpointCounters::table() {
  using C = CheckpointCounters;
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
          .sum(&C::returned)
          .sum(&C::ahead_returned)
          .sum(&C::store_returned)
          .part(&C::log)
          .when([](const C& c) { return c.sectors_ahead > 0; })
          .sum(&C::sectors_ahead, "sectors_ahead", "requests", "32 B reads of checkpoint buffers ahead of need")
          .when([](const C& c) { return c.store_written > 0; })
          .sum(&C::store_written, "store_written", "entries",
               "checkpoint entries written to the private store of the RT unit, in place of memory")
          .sum(&C::store_read, "store_read", "entries", "checkpoint entries read from the private store of the RT unit")
          .when([](const C& c) { return c.log.runs_written + c.log.copies_forced > 0; })
          .described([](const C& c, StatisticList& list, const std::string& prefix) {
            c.log.table().describe(c.log, list, prefix);
          });
  return table;
}

CheckpointUnit::CheckpointUnit(const sc_core::sc_module_name& name, const Config& config, const MemoryMap& map,
                               const traces::Header& header, unsigned entries, unsigned sm)
    : CheckpointModule(name),
      config_(config),
      map_(map),
      two_level_(header.two_level),
      header_(header),
      layout_(config, header),
      sm_(sm),
      lanes_(std::size_t{entries} * kMaxLanes),
      submitted_(std::size_t{entries} * kMaxLanes),
      reads_(std::size_t{entries} * kMaxLanes),
      writes_(config.write_queue > 0 ? config.write_queue : 1),
      ahead_(std::size_t{entries} * kMaxLanes),
      store_reads_(std::size_t{entries} * kMaxLanes),
      store_returns_(std::size_t{entries} * kMaxLanes) {
  require_allowed("rt.checkpoint", config);
  require_allowed("rt.private_store", config.store);
  if (map.checkpoint_entry_bytes() != config.entry_bytes) {
    throw Error("configuration", "rt.checkpoint.entry_bytes", "must be those of the memory map");
  }
  if ((map.checkpoint_log_entries() != 0) != (config.forward == CheckpointForward::reference)) {
    throw Error("configuration", "rt.checkpoint.forward", "must be that of the memory map");
  }
  log_entries_ = map.checkpoint_log_entries();
}

void CheckpointUnit::end_of_elaboration() {
  client_ = client.operator->();
  requests_ = writer_of(request);
  responses_ = reader_of(response);
}

void CheckpointUnit::restart() {
  make_anew(layout_, config_, header_);
  std::fill(lanes_.begin(), lanes_.end(), LaneContext());
  ahead_ = BoundedQueue<LaneId>(lanes_.size());  // of lanes whose round is over
  counters_ = {};
}

void CheckpointUnit::begin_lane(LaneId id, std::uint16_t slot, std::uint32_t round, bool replays,
                                std::uint32_t source_entries) {
  LaneContext& lane = lanes_[id];
  assert(lane.pending == 0 && !lane.flush && lane.reads_missing == 0);
  const bool queued = lane.reads_ahead;
  lane = {};
  lane.reads_ahead = queued;
  lane.place = layout_.begin(map_, sm_, slot, lane_of(id), round, replays, source_entries);
  if (replays) read_ahead(id);
}

// The lane's window of sectors to read ahead has moved.
void CheckpointUnit::read_ahead(LaneId id) {
  if (!layout_.reads_ahead() || lanes_[id].reads_ahead) return;
  lanes_[id].reads_ahead = true;
  ahead_.push(id);
}

bool CheckpointUnit::submit(LaneId id, unsigned entries, bool forwarded, bool last) {
  LaneContext& lane = lanes_[id];
  assert(lane.pending == 0 && !lane.flush);
  lane.over = last;
  lane.pending = static_cast<std::uint8_t>(layout_.submit(lane.place, entries, forwarded, last));
  counters_.max_entries = std::max<std::uint64_t>(counters_.max_entries, lane.place.written);
  lane.flush = last && config_.write_combine && (lane.pending > 0 || layout_.open_sector(lane.place) != kNoSector);
  if (lane.pending == 0 && !lane.flush) return false;
  submitted_.push(id);
  return true;
}

// Hands over as much of the lane as budget and room allow; true when nothing is left. One item completes at most one
// sector when combining (it is smaller), and touches at most two.
bool CheckpointUnit::take(LaneId id, unsigned& budget) {
  LaneContext& lane = lanes_[id];
  while (lane.pending > 0) {
    const bool stored = layout_.next_is_stored(lane.place);
    if (budget == 0 || (stored ? store_written_ : writes_.room() < layout_.most_sectors())) return false;
    const CheckpointLayout::Sectors sectors = layout_.append(lane.place);
    if (stored) {
      store_written_ = true;  // one port to write
      ++counters_.store_written;
    }
    for (unsigned i = 0; i < sectors.count; ++i) writes_.push(sectors.number[i]);
    if (sectors.straddles) ++counters_.straddling_written;
    if (!sectors.run) ++counters_.entries_written;
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
  assert(lanes_[id].reads_missing == 0);
  return start_read(id);
}

// Reads the lane's next entry, or the run entry before it; true when there is nothing to wait for.
bool CheckpointUnit::start_read(LaneId id) {
  LaneContext& lane = lanes_[id];
  do {
    lane.to_read = layout_.read(lane.place);
    if (!lane.to_read.run) ++counters_.entries_read;
    if (lane.to_read.straddles) ++counters_.straddling_read;
  } while (lane.to_read.run && lane.to_read.count == 0);
  read_ahead(id);
  if (lane.to_read.stored) {
    store_reads_.push(id);
    return false;
  }
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

// What comes from the store comes behind this cycle's responses of the memory.
void CheckpointUnit::read_store(Cycle now) {
  while (!store_returns_.empty() && store_returns_.front().due <= now) {
    const LaneId id = store_returns_.front().lane;
    store_returns_.pop();
    ++counters_.store_returned;
    client_->entry_read(id);
  }
  for (unsigned i = 0; i < config_.store.read_ports && !store_reads_.empty(); ++i) {
    store_returns_.push({now + config_.store.latency, store_reads_.front()});
    store_reads_.pop();
    ++counters_.store_read;
  }
}

void CheckpointUnit::issue(Cycle now) {
  if (lanes_at_store() > 0) read_store(now);
  if (!busy() || !requests_.can_push(now)) return;
  if (reads_.empty() && writes_.empty()) return issue_ahead(now);
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

// Nothing waits to be written, so no sector is read before it is written.
void CheckpointUnit::issue_ahead(Cycle now) {
  while (!ahead_.empty()) {
    const LaneId id = ahead_.front();
    const std::uint64_t sector = lanes_[id].over ? kNoSector : layout_.next_ahead(lanes_[id].place);
    if (sector == kNoSector) {
      ahead_.pop();
      lanes_[id].reads_ahead = false;
      continue;
    }
    MemoryRequest message;
    message.region = Region::checkpoint;
    message.address = sector * kSectorBytes;
    message.tag = id;
    message.prefetch = true;
    requests_.push(now, message);
    ++counters_.sectors_ahead;
    ++outstanding_;
    return;
  }
}

void CheckpointUnit::arrived(LaneId id, std::uint64_t address) {
  if (!layout_.names_nodes() || lanes_[id].over) return;
  const CheckpointLayout::Entries entries = layout_.arrived(lanes_[id].place, address / kSectorBytes);
  if (entries.count > 0) client_->entries_arrived(id, entries.first, entries.count);
}

void CheckpointUnit::respond(Cycle now) {
  const MemoryResponse* answer = responses_.front(now);
  if (answer == nullptr) return;
  const bool write = answer->write, ahead = answer->prefetch;
  const auto id = static_cast<LaneId>(answer->tag);
  const std::uint64_t address = answer->address;
  responses_.pop(now);
  assert(outstanding_ > 0);
  --outstanding_;
  if (write) {
    ++counters_.acknowledged;
    return;
  }
  arrived(id, address);
  if (ahead) {
    ++counters_.ahead_returned;
    return;
  }
  ++counters_.returned;
  LaneContext& lane = lanes_[id];
  assert(lane.reads_missing > 0);
  if (--lane.reads_missing != 0) return;
  if (!lane.to_read.run || start_read(id)) client_->entry_read(id);
}

void CheckpointUnit::accept(Cycle) {
  store_written_ = false;
  if (submitted_.empty()) return;
  unsigned budget = config_.lanes;
  while (!submitted_.empty() && take(submitted_.front(), budget)) {
    const LaneId id = submitted_.front();
    submitted_.pop();
    client_->entries_taken(id);
  }
  if (!submitted_.empty()) ++counters_.blocked_cycles;
}

void CheckpointUnit::count(RtUnitCounters& all) const { all.checkpoint.add(counters_.with_runs_of(layout_)); }

Inventory CheckpointUnit::inventory() const {
  return checkpoint_inventory(name(), config_, lanes_.size(), two_level_, log_entries_);
}

Inventory checkpoint_inventory(const char* name, const CheckpointConfig& config, std::uint64_t lanes, bool two_level,
                               std::uint64_t log_entries) {
  Inventory inventory{name, {}, {}};
  auto& storage = inventory.storage;
  const std::uint64_t sector_bits = kSectorBytes * 8;
  storage.push_back({"write_queue", StorageKind::ram, config.write_queue * (sector_bits + kSectorBytes + 48), 1, 1,
                     false, static_cast<unsigned>(sector_bits) + kSectorBytes + 48});
  storage.push_back({"submitted", StorageKind::ram, lanes * 8, 1, 1, false, 8});
  storage.push_back({"reads", StorageKind::ram, lanes * 8, 1, 1, false, 8});
  // Not in the paper's table: it does not say how entries become memory requests.
  const unsigned entry_bits = config.entry_bytes * 8;
  if (config.write_combine)
    storage.push_back({"open_sectors", StorageKind::ram, lanes * sector_bits, 1, 1, false, entry_bits});
  if (config.read_buffer)
    storage.push_back({"read_sectors", StorageKind::ram, lanes * sector_bits, 1, 1, false, entry_bits});
  if (log_entries != 0) {
    // A lane's run that is read, and the one that is being forwarded with its first entry, which may have to be copied.
    const unsigned run_bits = 2u * static_cast<unsigned>(std::bit_width(log_entries - 1)) + 1;
    storage.push_back({"runs", StorageKind::ram, lanes * (2 * run_bits + entry_bits), 1, 1, false, run_bits});
  }
  if (const CheckpointStoreConfig& store = config.store; store.entries > 0) {
    const std::uint64_t places = 2ull * store.entries * store.warps * kMaxLanes;
    storage.push_back({"private_store", StorageKind::ram, places * entry_bits, store.read_ports, 1, false, entry_bits});
    storage.push_back({"store_reads", StorageKind::ram, lanes * 8, 1, 1, false, 8});
  }
  if (config.read_ahead > 0) {
    // Lanes in turn; of each the next sector and the list's end.
    storage.push_back({"ahead", StorageKind::ram, lanes * (8 + 16 + 16), 1, 1, false, 40});
  }
  if (config.prefetch_nodes) storage.push_back({"named", StorageKind::ram, lanes * 16, 1, 1, false, 16});
  // Heads and levels of the queues of rays, head, level and full bits of the write queue, requests that are out,
  // whether the first of two sectors has been sent, and a bit a ray: two responses are missing (checkpoint_unit.sv).
  const unsigned ray_bits = static_cast<unsigned>(std::bit_width(lanes - 1));
  const auto places = config.write_queue;
  const std::uint64_t control = 2ull * (2 * ray_bits + 1) + static_cast<unsigned>(std::bit_width(places - 1)) +
                                static_cast<unsigned>(std::bit_width(places)) + places + 16 + 1 + lanes;
  storage.push_back({"control", StorageKind::flip_flop, control});
  auto& operators = inventory.operators;
  operators.push_back({"fp_compare", 32, 2ull * config.lanes});  // t-value validation: t_hit against t_min, t_max
  // offset x 20 = x 16 + x 4; powers of two are wires.
  // For each lane its source and destination entry; the RTL has it also for a read, its result and the end of
  // a submission.
  if (!std::has_single_bit(config.entry_bytes)) operators.push_back({"mul_constant", 16, 2ull * config.lanes + 3});
  operators.push_back({"int_add", 64, 2ull * config.lanes});  // base + slot offset + entry offset
  // BLAS header to number and back.
  if (config.entry_bytes == 8 && two_level) operators.push_back({"int_add", 64, 2ull * config.lanes});
  // t of each entry of a sector that comes, against t_max.
  if (config.prefetch_nodes) operators.push_back({"fp_compare", 32, kSectorBytes / config.entry_bytes});
  operators.push_back({"increment", 16, 2ull * config.lanes});    // source and destination offset
  operators.push_back({"int_compare", 16, 2ull * config.lanes});  // against the maximum size
  // What the RTL has beside (docs/results/rtl.md). An entry begins at any multiple of what divides both its size and a
  // sector's: it is shifted to its place with its byte mask, an entry that is read is shifted back.
  const unsigned positions =
      static_cast<unsigned>(kSectorBytes) / std::gcd(config.entry_bytes, static_cast<unsigned>(kSectorBytes));
  const unsigned shifts = static_cast<unsigned>(std::bit_width(positions - 1));
  operators.push_back({"mux", entry_bits + config.entry_bytes, shifts * (config.lanes + 1ull)});
  operators.push_back({"match", 48, places});  // a read waits for a write of its sector
  operators.push_back({"mux", 48, 2});         // a request is a read or a write
  operators.push_back({"mux", 1, 5 * lanes});  // the bit a ray is set, cleared and read
  operators.push_back({"increment", static_cast<unsigned>(control - lanes - places), 1});
  return inventory;
}

void CheckpointUnit::dump_state(std::ostream& out) const {
  out << name() << ": " << submitted_.size() << " lanes handing over, " << reads_.size() << " lanes to read, "
      << writes_.size() << " sectors to write, " << outstanding_ << " requests outstanding, " << lanes_at_store()
      << " lanes at the private store\n";
}

}  // namespace grtx::modules
