// The checkpoint unit in fast mode: the sectors that entries take to write and to read.
#include <algorithm>

#include "rtl_tlm/fast/fast_machine.h"

namespace grtx::tlm::fast {

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
  if (header_.checkpoint_order != "lifo" || !replay) return;
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

Cycle Machine::write_checkpoints(Cycle now, Number number, unsigned entries, bool last) {
  Checkpoints& c = checkpoints_[number];
  Sm& sm = sms_[lanes_[number].sm];
  CheckpointUnit::Counters& counters = sm.rt.checkpoint;
  const bool combine = config_.rt.checkpoint.write_combine;
  Cycle taken = now;
  const auto hand_over = [&] { taken = std::max(taken, sm.hand_over.reserve(now)); };
  if (c.written + entries > header_.checkpoint_capacity) {
    refuse(number, "writes more checkpoint entries than the header's checkpoint_capacity");
  }
  for (; entries > 0; --entries) {
    hand_over();
    const std::uint64_t begin = c.destination + c.written * kCheckpointEntryBytes;
    const std::uint64_t end = begin + kCheckpointEntryBytes;
    const std::uint64_t first = begin / kSectorBytes, final = (end - 1) / kSectorBytes;
    if (first != final) ++counters.straddling_written;
    if (!combine || first != final || end % kSectorBytes == 0) push_sector(now, number, first, true, false);
    if (!combine && first != final) push_sector(now, number, final, true, false);
    ++c.written;
    ++counters.entries_written;
  }
  counters.max_entries = std::max<std::uint64_t>(counters.max_entries, c.written);
  const std::uint64_t open = c.destination + c.written * kCheckpointEntryBytes;
  if (last && combine && c.written > 0 && open % kSectorBytes != 0) {
    hand_over();
    push_sector(now, number, open / kSectorBytes, true, false);
  }
  // The queue sends a sector a cycle.
  const std::size_t queued = sm.ports[kCheckpoint].queue.size();
  if (taken > now || queued > config_.rt.checkpoint.write_queue) {
    taken = std::max(taken, now + queued - std::min<std::size_t>(queued, config_.rt.checkpoint.write_queue));
    counters.blocked_cycles += taken - now;
  }
  return taken;
}

bool Machine::read_checkpoint(Cycle now, Number number) {
  Checkpoints& c = checkpoints_[number];
  CheckpointUnit::Counters& counters = sms_[lanes_[number].sm].rt.checkpoint;
  const bool lifo = header_.checkpoint_order == "lifo";
  const std::uint64_t index = lifo ? c.source_entries - 1 - c.read : c.read;
  if (index >= header_.checkpoint_capacity) {
    refuse(number, "reads more checkpoint entries than the header's checkpoint_capacity");
  }
  ++c.read;
  ++counters.entries_read;
  const std::uint64_t begin = c.source + index * kCheckpointEntryBytes;
  const std::uint64_t first = begin / kSectorBytes;
  const std::uint64_t final = (begin + kCheckpointEntryBytes - 1) / kSectorBytes;
  if (first != final) ++counters.straddling_read;
  const bool need_first = first != c.held, need_final = final != first && final != c.held;
  if (config_.rt.checkpoint.read_buffer) c.held = lifo ? first : final;
  if (!need_first && !need_final) return true;
  c.seen = 0;
  if (need_first) push_sector(now, number, first, false, !need_final);
  if (need_final) push_sector(now, number, final, false, true);
  return false;
}

}  // namespace grtx::tlm::fast
