// Checkpoint traffic of the outline model.
#include "rtl_tlm/sampled/outline_machine.h"

namespace grtx::tlm::outline {

using namespace modules;

void Machine::begin_checkpoints(unsigned s, unsigned slot, unsigned i, std::uint32_t round, Number number,
                                bool replay) {
  Checkpoints& c = checkpoints_[number];
  const std::uint64_t ray = map_.ray_slot(s, slot, i);
  c = {};
  c.destination = map_.checkpoint_entry(ray, round & 1, 0);
  c.source = map_.checkpoint_entry(ray, (round & 1) ^ 1, 0);
  if (header_.checkpoint_order != "lifo" || !replay) return;
  for (const Event* e = lanes_[number].next; e != lanes_[number].end; ++e) {
    if (e->kind() == EventKind::replay_take || e->kind() == EventKind::replay_forward) ++c.source_entries;
  }
}

void Machine::push_sector(Cycle now, Number number, std::uint64_t sector, bool write, bool last) {
  Sm& sm = *sms_[lanes_[number].sm];
  const std::uint64_t address = sector * kSectorBytes;
  RingQueue<Request>& queue = sm.ports[kCheckpoint].queue;
  queue.push({sm.tags.line_address(address), number, sm.tags.sector_bit(address), kNoPlace, write, last});
  if (queue.size() == 1) serve(now, lanes_[number].sm);
}

void Machine::write_checkpoints(Cycle now, Number number, unsigned entries, bool last) {
  Checkpoints& c = checkpoints_[number];
  const bool combine = config_.rt.checkpoint.write_combine;
  for (; entries > 0; --entries) {
    const std::uint64_t begin = c.destination + c.written * traces::kCheckpointEntryBytes;
    const std::uint64_t end = begin + traces::kCheckpointEntryBytes;
    const std::uint64_t first = begin / kSectorBytes, final = (end - 1) / kSectorBytes;
    if (!combine || first != final || end % kSectorBytes == 0) push_sector(now, number, first, true, false);
    if (!combine && first != final) push_sector(now, number, final, true, false);
    ++c.written;
  }
  const std::uint64_t open = c.destination + c.written * traces::kCheckpointEntryBytes;
  if (last && combine && c.written > 0 && open % kSectorBytes != 0) {
    push_sector(now, number, open / kSectorBytes, true, false);
  }
}

/// Whether the entry is there already; else the lane waits.
bool Machine::read_checkpoint(Cycle now, Number number) {
  Checkpoints& c = checkpoints_[number];
  const bool lifo = header_.checkpoint_order == "lifo";
  const std::uint64_t index = lifo ? c.source_entries - 1 - c.read : c.read;
  ++c.read;
  const std::uint64_t begin = c.source + index * traces::kCheckpointEntryBytes;
  const std::uint64_t first = begin / kSectorBytes;
  const std::uint64_t final = (begin + traces::kCheckpointEntryBytes - 1) / kSectorBytes;
  const bool need_first = first != c.held, need_final = final != first && final != c.held;
  if (config_.rt.checkpoint.read_buffer) c.held = lifo ? first : final;
  if (!need_first && !need_final) return true;
  Lane& lane = lanes_[number];
  lane.seen = 0;
  if (need_first) push_sector(now, number, first, false, !need_final);
  if (need_final) push_sector(now, number, final, false, true);
  return false;
}

}  // namespace grtx::tlm::outline
