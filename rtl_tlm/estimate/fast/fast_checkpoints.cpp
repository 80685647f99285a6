// The checkpoint unit in fast mode: the sectors that entries take to write and to read.
#include <algorithm>
#include <utility>

#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

namespace grtx::sim::fast {

using namespace modules;

void Machine::begin_checkpoints(unsigned s, unsigned slot, unsigned i, std::uint32_t round, Number number,
                                bool replay) {
  std::uint32_t entries = 0;
  if (layout_->reads_backwards() && replay) entries = source_entries({lanes_[number].next, lanes_[number].end});
  checkpoints_[number].place = layout_->begin(map_, map_.ray_slot(s, slot, i), round, entries);
}

void Machine::push_sector(Cycle now, Number number, std::uint64_t sector, bool write, bool last) {
  const unsigned s = lanes_[number].sm;
  Sm& sm = sms_[s];
  const std::uint64_t address = sector * kSectorBytes;
  ++(write ? sm.rt.checkpoint.sectors_written : sm.rt.checkpoint.sectors_read);
  RingQueue<Request>& queue = sm.ports[kCheckpoint].queue;
  queue.push({sm.tags.line_address(address), number, sm.tags.sector_bit(address), Region::checkpoint, write, last});
  sm.waiting |= 1u << kCheckpoint;
  if (queue.size() == 1) serve(now, s);
}

CheckpointLayout::Sectors Machine::add_entry(Number number) {
  CheckpointLayout::Lane& lane = checkpoints_[number].place;
  const CheckpointLayout::Sectors sectors = layout_->write(lane);
  CheckpointUnit::Counters& counters = sms_[lanes_[number].sm].rt.checkpoint;
  ++counters.entries_written;
  counters.max_entries = std::max<std::uint64_t>(counters.max_entries, lane.written);
  return sectors;
}

CheckpointLayout::Sectors Machine::take_source(Number number) {
  ++sms_[lanes_[number].sm].rt.checkpoint.entries_read;
  CheckpointLayout::Sectors sectors = layout_->read(checkpoints_[number].place);
  // An entry's sectors are asked for at once, in the order of their addresses also when the buffer is read backwards.
  if (sectors.count == 2 && sectors.number[0] > sectors.number[1]) std::swap(sectors.number[0], sectors.number[1]);
  return sectors;
}

Cycle Machine::write_checkpoints(Cycle now, Number number, unsigned entries, bool last) {
  Sm& sm = sms_[lanes_[number].sm];
  CheckpointUnit::Counters& counters = sm.rt.checkpoint;
  Cycle taken = now;
  const auto hand_over = [&] { taken = std::max(taken, sm.hand_over.reserve(now)); };
  for (; entries > 0; --entries) {
    hand_over();
    const CheckpointLayout::Sectors sectors = add_entry(number);
    for (unsigned i = 0; i < sectors.count; ++i) push_sector(now, number, sectors.number[i], true, false);
    if (sectors.straddles) ++counters.straddling_written;
  }
  const std::uint64_t open = last ? layout_->open_sector(checkpoints_[number].place) : CheckpointLayout::kNoSector;
  if (open != CheckpointLayout::kNoSector) {
    hand_over();
    push_sector(now, number, open, true, false);
  }
  // The queue sends a sector a cycle.
  const std::size_t queued = sm.ports[kCheckpoint].timed();
  if (taken > now || queued > config_.rt.checkpoint.write_queue) {
    taken = std::max(taken, now + queued - std::min<std::size_t>(queued, config_.rt.checkpoint.write_queue));
    counters.blocked_cycles += taken - now;
  }
  return taken;
}

bool Machine::read_checkpoint(Cycle now, Number number) {
  const CheckpointLayout::Sectors sectors = take_source(number);
  if (sectors.straddles) ++sms_[lanes_[number].sm].rt.checkpoint.straddling_read;
  if (sectors.count == 0) return true;
  checkpoints_[number].seen = 0;
  for (unsigned i = 0; i < sectors.count; ++i) {
    push_sector(now, number, sectors.number[i], false, i + 1 == sectors.count);
  }
  return false;
}

void Machine::warm_checkpoints(unsigned s, Sm& sm, Number number, unsigned entries, bool last) {
  const auto warm = [&](std::uint64_t sector) {
    warm_line(s, sm, kCheckpoint, {sector * kSectorBytes, Region::checkpoint}, true);
  };
  for (; entries > 0; --entries) {
    const CheckpointLayout::Sectors sectors = add_entry(number);
    for (unsigned i = 0; i < sectors.count; ++i) warm(sectors.number[i]);
  }
  if (!last) return;
  const std::uint64_t open = layout_->open_sector(checkpoints_[number].place);
  if (open != CheckpointLayout::kNoSector) warm(open);
}

void Machine::warm_source(unsigned s, Sm& sm, Number number) {
  const CheckpointLayout::Sectors sectors = take_source(number);
  for (unsigned i = 0; i < sectors.count; ++i) {
    warm_line(s, sm, kCheckpoint, {sectors.number[i] * kSectorBytes, Region::checkpoint}, false);
  }
}

}  // namespace grtx::sim::fast
