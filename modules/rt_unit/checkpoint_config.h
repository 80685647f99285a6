// The parameters of checkpoint buffers: what an entry is, and what moves it. The checkpoint unit, its layout without
// time and the memory map ask here.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/named_enum.h"
#include "grtx/modules/kernel/parameter.h"

namespace grtx::modules {

/// What becomes of a source entry that is not taken: rewrite: it is written to the destination. reference: it stays
/// where it is, and the destination names it.
enum class CheckpointForward : std::uint8_t { rewrite, reference };
constexpr auto enum_names(CheckpointForward) {
  using enum CheckpointForward;
  return std::to_array<EnumName<CheckpointForward>>({{rewrite, "rewrite"}, {reference, "reference"}});
}

struct CheckpointConfig {
  unsigned lanes = 4;  ///< or last sectors
  unsigned write_queue = 16;
  bool write_combine = false;  ///< else each entry writes every sector it touches
  bool read_buffer = false;    ///< else each entry reads every sector it touches
  unsigned entry_bytes = 20;   ///< 8, 16, 20 or 28
  CheckpointForward forward = CheckpointForward::rewrite;
  unsigned read_ahead = 0;      ///< sectors; 0: off
  bool prefetch_nodes = false;  ///< of entries that have come and will be taken
  void parameters(ParameterList& list) {
    list.add("lanes", lanes, {1, 64}, "entries/cycle", "checkpoint entries taken from lanes in a cycle", kOurs);
    list.add("write_queue", write_queue, {2, kMaxEntries}, "sectors", "checkpoint sectors waiting to be written",
             kOurs);
    list.add("write_combine", write_combine, "a lane's entries gather in its open sector before they are written",
             kOurs);
    list.add("read_buffer", read_buffer, "a lane keeps the last sector it replayed", kOurs);
    list.add("entry_bytes", entry_bytes, {8, 28}, "B",
             "checkpoint entry in memory, 8, 16, 20 or 28 (checkpoint_unit.md)",
             from_paper("GRTX, Section IV-B: 8 + 8 + 4"));
    list.add("forward", forward, "a source entry that is not taken is written again, or named by a run entry",
             from_paper("GRTX, Section IV-B: written to the destination"));
    list.add("read_ahead", read_ahead, {0, 64}, "sectors",
             "of a lane's source buffer, requested from traceRay on before they are needed; 0: off", kOurs);
    list.add("prefetch_nodes", prefetch_nodes,
             "nodes that source entries name are prefetched when these come, if they will be taken", kOurs);
  }
  static constexpr const char* kEntryBytesRule = "must be 8, 16, 20 or 28";
  static bool allows_entry_bytes(unsigned bytes) { return bytes == 8 || bytes == 16 || bytes == 20 || bytes == 28; }
};

}  // namespace grtx::modules
