#include "grtx/rtl_tlm/estimate/fast/fast_checkpoints.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "grtx/modules/rt_unit/decide/event_effect.h"

namespace grtx::sim::fast {

using namespace modules;

Checkpoints::Checkpoints(Shared& shared, unsigned sm, L1& l1)
    : shared_(shared),
      sm_(sm),
      l1_(l1),
      layout_(shared.config.rt.checkpoint, shared.header),
      lanes_(shared.header.checkpoint ? std::size_t{shared.config.rt.warp_buffer.entries} * kMaxLanes : 0),
      hand_over_(shared.config.rt.checkpoint.lanes),
      store_read_(shared.config.rt.checkpoint.store.read_ports) {}

void Checkpoints::begin(Cycle now, std::uint32_t lane, unsigned slot, std::uint32_t round, bool replay,
                        std::span<const traces::Event> events) {
  const std::uint32_t entries = layout_.needs_source_entries() && replay ? source_entries(events) : 0;
  Lane& of = lanes_[lane];
  of.place = layout_.begin(shared_.map, sm_, slot, lane % kMaxLanes, round, replay, entries);
  of.seen = 0;
  of.run = false;
  if (replay) read_ahead(now, lane, true);
}

unsigned Checkpoints::submit(Lane& lane, unsigned entries, bool forwarded, bool last) {
  const unsigned items = layout_.submit(lane.place, entries, forwarded, last);
  counters_.max_entries = std::max<std::uint64_t>(counters_.max_entries, lane.place.written);
  return items;
}

CheckpointLayout::Sectors Checkpoints::next_written(Lane& lane) {
  const CheckpointLayout::Sectors sectors = layout_.append(lane.place);
  if (!sectors.run) ++counters_.entries_written;
  return sectors;
}

CheckpointLayout::Sectors Checkpoints::next_read(Lane& lane) {
  CheckpointLayout::Sectors sectors = layout_.read(lane.place);
  lane.run = sectors.run;
  if (!sectors.run) ++counters_.entries_read;
  // An entry's sectors are asked for at once, in the order of their addresses also when the buffer is read backwards.
  if (sectors.count == 2 && sectors.number[0] > sectors.number[1]) std::swap(sectors.number[0], sectors.number[1]);
  return sectors;
}

void Checkpoints::push(Cycle now, std::uint32_t lane, std::uint64_t sector, bool write, bool last) {
  ++(write ? counters_.sectors_written : counters_.sectors_read);
  l1_.push(kCheckpoint, lane, {sector * kSectorBytes, 1, Region::checkpoint}, write, last);
  if (l1_.queued(kCheckpoint) == 1) l1_.serve(now);
}

Cycle Checkpoints::write(Cycle now, std::uint32_t lane, unsigned entries, bool forwarded, bool last) {
  Cycle taken = now;
  const auto hand_over = [&] { taken = std::max(taken, hand_over_.reserve(now)); };
  for (unsigned items = submit(lanes_[lane], entries, forwarded, last); items > 0; --items) {
    hand_over();
    const CheckpointLayout::Sectors sectors = next_written(lanes_[lane]);
    if (sectors.stored) {
      taken = std::max(taken, store_write_.reserve(now));
      ++counters_.store_written;
    }
    for (unsigned i = 0; i < sectors.count; ++i) push(now, lane, sectors.number[i], true, false);
    if (sectors.straddles) ++counters_.straddling_written;
  }
  const std::uint64_t open = last ? layout_.open_sector(lanes_[lane].place) : CheckpointLayout::kNoSector;
  if (open != CheckpointLayout::kNoSector) {
    hand_over();
    push(now, lane, open, true, false);
  }
  // The queue sends a sector a cycle.
  const std::size_t queued = l1_.timed(kCheckpoint);
  const std::size_t most = shared_.config.rt.checkpoint.write_queue;
  if (taken > now || queued > most) {
    taken = std::max(taken, now + queued - std::min(queued, most));
    // Of the unit: cycles in which several lanes wait count once.
    counters_.blocked_cycles += taken - std::min(taken, std::max(now, blocked_until_));
    blocked_until_ = std::max(blocked_until_, taken);
  }
  return taken;
}

// One in so many sectors takes time, as one in so many events does.
void Checkpoints::read_ahead(Cycle now, std::uint32_t lane, bool timed) {
  if (!layout_.reads_ahead()) return;
  for (std::uint64_t sector; (sector = layout_.next_ahead(lanes_[lane].place)) != CheckpointLayout::kNoSector;) {
    const std::uint64_t address = sector * kSectorBytes;
    if (!timed || !shared_.chosen(sector, lane)) {
      l1_.warm_ahead({address, Region::checkpoint});
      if (names_nodes()) arrives(lane, {now, sector, false});
      continue;
    }
    ++counters_.sectors_ahead;
    l1_.push(kCheckpoint, lane | kAheadOf, {address, 1, Region::checkpoint}, false, true);
    if (l1_.queued(kCheckpoint) == 1) l1_.serve(now);
  }
}

void Checkpoints::answered_ahead(std::uint32_t lane, Cycle seen, std::uint64_t line, std::uint8_t sectors) {
  ++counters_.ahead_returned;
  if (!names_nodes()) return;
  arrives(lane, {seen, line / kSectorBytes + static_cast<unsigned>(std::countr_zero(sectors)), true});
}

void Checkpoints::arrives(std::uint32_t lane, const Arrival& arrival) {
  lanes_[lane].arrivals.push(arrival);
  if (!std::exchange(lanes_[lane].arriving, true)) shared_.agenda.add(arrival.seen, {What::source, sm_, lane});
}

bool Checkpoints::entry_read(Cycle now, std::uint32_t lane) {
  const Lane& of = lanes_[lane];
  if (names_nodes()) {
    for (unsigned i = 0; i < of.asked.count; ++i) arrives(lane, {now, of.asked.number[i], true});
  }
  return !of.run || read(now, lane);
}

bool Checkpoints::read(Cycle now, std::uint32_t lane) {
  CheckpointLayout::Sectors sectors;
  do {
    sectors = next_read(lanes_[lane]);
    if (sectors.straddles) ++counters_.straddling_read;
  } while (sectors.run && sectors.count == 0);
  read_ahead(now, lane, true);
  if (sectors.stored) {
    ++counters_.store_read;
    ++counters_.store_returned;
    const Cycle asked = store_read_.reserve(now + 1);
    shared_.agenda.add(asked + shared_.config.rt.checkpoint.store.latency, {What::lane, sm_, lane});
    return false;
  }
  if (sectors.count == 0) return true;
  lanes_[lane].seen = 0;
  lanes_[lane].asked = sectors;
  for (unsigned i = 0; i < sectors.count; ++i) push(now, lane, sectors.number[i], false, i + 1 == sectors.count);
  return false;
}

void Checkpoints::answered(std::uint32_t lane, Cycle seen, bool write, bool last) {
  if (write) {
    ++counters_.acknowledged;
    return;
  }
  ++counters_.returned;
  lanes_[lane].seen = std::max(lanes_[lane].seen, seen);
  if (last) shared_.agenda.add(lanes_[lane].seen, {What::lane, sm_, lane});
}

void Checkpoints::warm_write(std::uint32_t lane, unsigned entries, bool forwarded, bool last) {
  for (unsigned items = submit(lanes_[lane], entries, forwarded, last); items > 0; --items) {
    const CheckpointLayout::Sectors sectors = next_written(lanes_[lane]);
    for (unsigned i = 0; i < sectors.count; ++i) warm(sectors.number[i], true);
  }
  if (!last) return;
  const std::uint64_t open = layout_.open_sector(lanes_[lane].place);
  if (open != CheckpointLayout::kNoSector) warm(open, true);
}

void Checkpoints::warm_read(Cycle now, std::uint32_t lane) {
  CheckpointLayout::Sectors sectors;
  do {
    sectors = next_read(lanes_[lane]);
    for (unsigned i = 0; i < sectors.count; ++i) warm(sectors.number[i], false);
    for (unsigned i = 0; names_nodes() && i < sectors.count; ++i) arrives(lane, {now, sectors.number[i], false});
  } while (sectors.run);
  read_ahead(now, lane, false);
}

}  // namespace grtx::sim::fast
