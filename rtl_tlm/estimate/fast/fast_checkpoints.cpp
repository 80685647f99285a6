#include "grtx/rtl_tlm/estimate/fast/fast_checkpoints.h"

#include <algorithm>
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
      hand_over_(shared.config.rt.checkpoint.lanes) {}

void Checkpoints::begin(std::uint32_t lane, unsigned slot, std::uint32_t round, bool replay,
                        std::span<const traces::Event> events, const traces::Ray& ray) {
  const std::uint32_t entries = layout_.needs_source_entries() && replay ? source_entries(events) : 0;
  Lane& of = lanes_[lane];
  of.place = layout_.begin(shared_.map, sm_, slot, lane % kMaxLanes, round, replay, entries, ray);
  of.seen = 0;
}

void Checkpoints::submit(Lane& lane, unsigned entries) {
  layout_.submit(lane.place, entries);
  counters_.max_entries = std::max<std::uint64_t>(counters_.max_entries, lane.place.written);
}

CheckpointLayout::Sectors Checkpoints::next_written(Lane& lane) {
  ++counters_.entries_written;
  return layout_.append(lane.place);
}

CheckpointLayout::Sectors Checkpoints::next_read(Lane& lane) {
  CheckpointLayout::Sectors sectors = layout_.read(lane.place);
  ++counters_.entries_read;
  // An entry's sectors are asked for at once, in the order of their addresses also when the buffer is read backwards.
  if (sectors.count == 2 && sectors.number[0] > sectors.number[1]) std::swap(sectors.number[0], sectors.number[1]);
  return sectors;
}

void Checkpoints::push(Cycle now, std::uint32_t lane, std::uint64_t sector, bool write, bool last) {
  ++(write ? counters_.sectors_written : counters_.sectors_read);
  l1_.push(kCheckpoint, lane, {sector * kSectorBytes, 1, Region::checkpoint}, write, last);
  if (l1_.queued(kCheckpoint) == 1) l1_.serve(now);
}

Cycle Checkpoints::write(Cycle now, std::uint32_t lane, unsigned entries, bool last) {
  Lane& of = lanes_[lane];
  Cycle taken = now;
  const auto hand_over = [&] { taken = std::max(taken, hand_over_.reserve(now)); };
  submit(of, entries);
  for (; entries > 0; --entries) {
    hand_over();
    const CheckpointLayout::Sectors sectors = next_written(of);
    for (unsigned i = 0; i < sectors.count; ++i) push(now, lane, sectors.number[i], true, false);
    if (sectors.straddles) ++counters_.straddling_written;
  }
  while (last && layout_.has_open_sector(of.place)) {
    hand_over();
    push(now, lane, layout_.close_sector(of.place), true, false);
  }
  // The queue sends a sector a cycle.
  const std::size_t queued = l1_.timed(kCheckpoint);
  const std::size_t most = shared_.config.rt.checkpoint.write_queue;
  if (taken > now || queued > most) {
    taken = std::max(taken, now + queued - std::min(queued, most));
    // The unit's blocked cycles: one in which several lanes wait counts once.
    counters_.blocked_cycles += taken - std::min(taken, std::max(now, blocked_until_));
    blocked_until_ = std::max(blocked_until_, taken);
  }
  return taken;
}

bool Checkpoints::read(Cycle now, std::uint32_t lane) {
  const CheckpointLayout::Sectors sectors = next_read(lanes_[lane]);
  if (sectors.straddles) ++counters_.straddling_read;
  if (sectors.count == 0) return true;
  lanes_[lane].seen = 0;
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

void Checkpoints::warm_write(std::uint32_t lane, unsigned entries, bool last) {
  Lane& of = lanes_[lane];
  submit(of, entries);
  for (; entries > 0; --entries) {
    const CheckpointLayout::Sectors sectors = next_written(of);
    for (unsigned i = 0; i < sectors.count; ++i) warm(sectors.number[i], true);
  }
  while (last && layout_.has_open_sector(of.place)) warm(layout_.close_sector(of.place), true);
}

void Checkpoints::warm_read(std::uint32_t lane) {
  const CheckpointLayout::Sectors sectors = next_read(lanes_[lane]);
  for (unsigned i = 0; i < sectors.count; ++i) warm(sectors.number[i], false);
}

}  // namespace grtx::sim::fast
