// The checkpoint unit in fast mode: the sectors that entries take to write and to read.
#include <algorithm>

#include "grtx/rtl_tlm/estimate/fast/fast_machine.h"

namespace grtx::sim::fast {

using namespace modules;
using traces::Event;
using traces::EventKind;
using traces::kCheckpointEntryBytes;

void Machine::begin_checkpoints(unsigned s, unsigned slot, unsigned i, std::uint32_t round, Number number,
                                bool replay) {
  Checkpoints& c = checkpoints_[number];
  const std::uint64_t ray = map_.ray_slot(s, slot, i);
  c = {};
  c.destination = map_.checkpoint_entry(ray, round & 1, 0);
  c.source = map_.checkpoint_entry(ray, (round & 1) ^ 1, 0);
  if (header_.checkpoint_order != traces::CheckpointOrder::lifo || !replay) return;
  c.source_entries =
      static_cast<std::uint32_t>(std::count_if(lanes_[number].next, lanes_[number].end, [](const Event& e) {
        return e.kind() == EventKind::replay_take || e.kind() == EventKind::replay_forward;
      }));
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

// Returns whether the entry lies in two sectors.
template <typename F>
bool Machine::add_entry(Number number, F&& sector) {
  Checkpoints& c = checkpoints_[number];
  if (c.written >= header_.checkpoint_capacity) {
    refuse(number, "writes more checkpoint entries than the header's checkpoint_capacity");
  }
  const bool combine = config_.rt.checkpoint.write_combine;
  const std::uint64_t begin = c.destination + c.written * kCheckpointEntryBytes;
  const std::uint64_t end = begin + kCheckpointEntryBytes;
  const std::uint64_t first = begin / kSectorBytes, final = (end - 1) / kSectorBytes;
  if (!combine || first != final || end % kSectorBytes == 0) sector(first);
  if (!combine && first != final) sector(final);
  CheckpointUnit::Counters& counters = sms_[lanes_[number].sm].rt.checkpoint;
  ++counters.entries_written;
  counters.max_entries = std::max<std::uint64_t>(counters.max_entries, ++c.written);
  return first != final;
}

std::uint64_t Machine::open_sector(Number number) const {
  const Checkpoints& c = checkpoints_[number];
  const std::uint64_t open = c.destination + c.written * kCheckpointEntryBytes;
  return config_.rt.checkpoint.write_combine && c.written > 0 && open % kSectorBytes != 0 ? open / kSectorBytes : 0;
}

Cycle Machine::write_checkpoints(Cycle now, Number number, unsigned entries, bool last) {
  Sm& sm = sms_[lanes_[number].sm];
  CheckpointUnit::Counters& counters = sm.rt.checkpoint;
  Cycle taken = now;
  const auto hand_over = [&] { taken = std::max(taken, sm.hand_over.reserve(now)); };
  for (; entries > 0; --entries) {
    hand_over();
    const bool straddles =
        add_entry(number, [&](std::uint64_t sector) { push_sector(now, number, sector, true, false); });
    if (straddles) ++counters.straddling_written;
  }
  if (const std::uint64_t open = last ? open_sector(number) : 0; open != 0) {
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

Machine::Source Machine::take_source(Number number) {
  Checkpoints& c = checkpoints_[number];
  const bool lifo = header_.checkpoint_order == traces::CheckpointOrder::lifo;
  const std::uint64_t index = lifo ? c.source_entries - 1 - c.read : c.read;
  if (index >= header_.checkpoint_capacity) {
    refuse(number, "reads more checkpoint entries than the header's checkpoint_capacity");
  }
  ++c.read;
  ++sms_[lanes_[number].sm].rt.checkpoint.entries_read;
  const std::uint64_t begin = c.source + index * kCheckpointEntryBytes;
  Source source{begin / kSectorBytes, (begin + kCheckpointEntryBytes - 1) / kSectorBytes};
  source.need_first = source.first != c.held;
  source.need_final = source.final != source.first && source.final != c.held;
  if (config_.rt.checkpoint.read_buffer) c.held = lifo ? source.first : source.final;
  return source;
}

bool Machine::read_checkpoint(Cycle now, Number number) {
  const Source source = take_source(number);
  if (source.first != source.final) ++sms_[lanes_[number].sm].rt.checkpoint.straddling_read;
  if (!source.need_first && !source.need_final) return true;
  checkpoints_[number].seen = 0;
  if (source.need_first) push_sector(now, number, source.first, false, !source.need_final);
  if (source.need_final) push_sector(now, number, source.final, false, true);
  return false;
}

void Machine::warm_checkpoints(unsigned s, Sm& sm, Number number, unsigned entries, bool last) {
  const auto warm = [&](std::uint64_t sector) {
    warm_line(s, sm, kCheckpoint, {sector * kSectorBytes, Region::checkpoint}, true);
  };
  for (; entries > 0; --entries) add_entry(number, warm);
  if (const std::uint64_t open = last ? open_sector(number) : 0; open != 0) warm(open);
}

void Machine::warm_source(unsigned s, Sm& sm, Number number) {
  const Source source = take_source(number);
  const auto warm = [&](std::uint64_t sector) {
    warm_line(s, sm, kCheckpoint, {sector * kSectorBytes, Region::checkpoint}, false);
  };
  if (source.need_first) warm(source.first);
  if (source.need_final) warm(source.final);
}

}  // namespace grtx::sim::fast
