// SPDX-License-Identifier: Apache-2.0
// The ray generation shader if hits are in an unsorted list per ray (traces::Tracing::list), as in GRay. Before each
// batch it scans the whole list and keeps the nearest hits beyond the last batch, sorted, in registers.
// docs/model/simt_core.md.
#include <algorithm>

#include "grtx/modules/messages/lane_loop.h"
#include "grtx/modules/simt/decide/shader_program.h"

namespace grtx::modules {

bool ShaderProgram::has_batch(const Warp& warp, unsigned batch) const {
  bool more = false;
  for_each_bit(warp.active, [&](unsigned lane) {
    more = more || round_of(warp, lane).processed_count > std::uint64_t{batch} * costs_.list_batch;
  });
  return more;
}

// Rays that have no further batch do not take part. Every entry is compared with all places of the batch, whether it is
// kept or not, because registers cannot be indexed.
void ShaderProgram::scan_list(unsigned slot, ShaderPhase& phase) {
  Warp& warp = warps_[slot];
  LaneCounts entries{};
  std::uint32_t most = 0;
  for_each_bit(warp.active, [&](unsigned lane) {
    if (round_of(warp, lane).processed_count <= std::uint64_t{warp.batch} * costs_.list_batch) return;
    entries[lane] = filled(warp, lane);
    most = std::max(most, entries[lane]);
  });
  const std::uint64_t each = costs_.list_per_entry + std::uint64_t{costs_.list_exchange} * (costs_.list_batch - 1);
  phase.reset(PhaseKind::sort, each * most);
  for_each_entry(
      map_.warp_slot(sm_, slot), warp.active, entries, [](unsigned, std::uint32_t i) { return i; }, false, phase);
  ++warp.sort_pass;
}

}  // namespace grtx::modules
