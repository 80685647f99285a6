// SPDX-License-Identifier: Apache-2.0
// The shaders in single-round tracing (traces::Header::tracing): the any-hit shader appends hits, the ray generation
// shader sorts them. docs/model/simt_core.md.
#include <algorithm>
#include <bit>
#include <cassert>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/simt/decide/shader_program.h"

namespace grtx::modules {

// An append writes one entry and reads none. The append that fills the buffer builds a heap: it reads all entries and
// writes those that move. In a full buffer a hit is compared with the root; a nearer hit replaces it and sinks, reading
// two children per level. Which child it follows is not in the trace, so the leftmost path is assumed.
void ShaderProgram::any_hit_single(const AnyHitBatch& batch, ShaderPhase& phase) {
  Warp& warp = warps_[batch.slot];
  const std::uint64_t warp_slot = map_.warp_slot(sm_, batch.slot);
  LaneCounts reads{};
  LaneCounts writes{};
  LaneMask filling = 0;
  LaneMask sinking = 0;
  std::array<std::uint32_t, kMaxLanes> appended{};  // index of the new entry of a lane that appends
  std::uint32_t most_moves = 0;
  for_each_bit(batch.lanes, [&](unsigned lane) {
    const std::uint32_t fill = filled(warp, lane);
    const std::uint32_t shifts = std::min<std::uint32_t>(batch.shifts[lane], k_);
    const traces::LeafOutcome outcome = batch.outcome[lane];
    std::uint32_t moves = shifts;
    if (outcome == traces::LeafOutcome::inserted && fill < k_) {
      appended[lane] = fill;
      writes[lane] = 1;
      if (fill + 1 == k_) {
        filling |= bit(lane);
        reads[lane] = fill;
        writes[lane] += shifts;
        moves = std::max(moves, k_ / 2);  // every inner entry of the heap is compared at least once
      }
      warp.fill[lane] = static_cast<std::int32_t>(fill + 1);
    } else if (outcome == traces::LeafOutcome::displaced) {
      sinking |= bit(lane);
      reads[lane] = std::min(1 + 2 * (shifts + 1), fill);
      writes[lane] = shifts + 1;
    } else {
      reads[lane] = std::min(1U, fill);
    }
    most_moves = std::max(most_moves, moves);
  });
  phase.reset(PhaseKind::any_hit, any_hit_instructions(batch.lanes, most_moves));

  const auto read_at = [&](unsigned lane, std::uint32_t i) {
    if ((filling & bit(lane)) != 0 || i == 0) return i;
    const std::uint32_t level = (i + 1) / 2;
    return std::min((1U << level) - (i % 2 == 0 ? 0U : 1U), k_ - 1);
  };
  const auto write_at = [&](unsigned lane, std::uint32_t i) {
    if ((sinking & bit(lane)) != 0) return std::min((1U << i) - 1, k_ - 1);
    return i == 0 ? appended[lane] : i - 1;
  };
  // Sinking reads level after level, each dependent on the previous; building a heap reads all entries anyway.
  std::uint32_t levels = 0;
  for_each_bit(sinking, [&](unsigned lane) { levels = std::max(levels, reads[lane]); });
  for_each_entry(warp_slot, batch.lanes, reads, read_at, false, phase,
                 [&](std::uint32_t i) { return costs_.dependent_loads && i % 2 == 0 && i + 1 < levels; });
  close_steps(phase);
  for_each_entry(warp_slot, batch.lanes, writes, write_at, true, phase);
}

bool ShaderProgram::sorts(unsigned slot) const {
  const Warp& warp = warps_[slot];
  if (list_) return warp.sort_pass == warp.batch && has_batch(warp, warp.batch);
  bool more = false;
  for_each_bit(warp.active, [&](unsigned lane) { more = more || warp.sort_pass < sort_passes(filled(warp, lane)); });
  return more;
}

unsigned ShaderProgram::sort_passes(std::uint32_t entries) const {
  return single_ && entries > 1 ? static_cast<unsigned>(std::bit_width(entries - 1)) : 0;
}

void ShaderProgram::sort(unsigned slot, ShaderPhase& phase) {
  if (list_) return scan_list(slot, phase);
  Warp& warp = warps_[slot];
  const std::uint64_t warp_slot = map_.warp_slot(sm_, slot);
  LaneCounts entries{};
  std::uint32_t most = 0;
  for_each_bit(warp.active, [&](unsigned lane) {
    if (warp.sort_pass < sort_passes(filled(warp, lane))) entries[lane] = filled(warp, lane);
    most = std::max(most, entries[lane]);
  });
  phase.reset(PhaseKind::sort, std::uint64_t{costs_.sort_per_entry} * most);
  const unsigned from = warp.sort_pass % 2 * k_;  // the two halves of the buffer alternate as source
  const unsigned to = k_ - from;
  const auto read_at = [&](unsigned, std::uint32_t i) { return from + i; };
  const auto write_at = [&](unsigned, std::uint32_t i) { return to + i; };
  for_each_entry(warp_slot, warp.active, entries, read_at, false, phase);
  for_each_entry(warp_slot, warp.active, entries, write_at, true, phase);
  ++warp.sort_pass;
}

}  // namespace grtx::modules
