// SPDX-License-Identifier: Apache-2.0
// Keys and counters of the checkpoint unit. Its untimed layout and the memory map use the keys, too.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/traffic_charging.h"
#include "grtx/modules/rt_unit/decide/unit_implementation.h"
#include "grtx/modules/rt_unit/part/part_info.h"
#include "grtx/traces/node_layout.h"

namespace grtx::modules {

struct CheckpointConfig {
  unsigned lanes = 4;  ///< entries, or open sectors at the end of a round, accepted per cycle
  unsigned write_queue = 16;
  bool write_combine = false;  ///< false: each entry writes every sector it touches
  unsigned open_sectors = 1;   ///< per lane, with write_combine; more than one is useful only with bins
  bool read_buffer = false;    ///< false: each entry reads every sector it touches
  unsigned entry_bytes = traces::kCheckpointEntryBytes;  ///< 8, 16, 20 or 28
  TrafficCharging traffic = TrafficCharging::charged;
  UnitImplementation implementation = UnitImplementation::tlm;
  void parameters(ParameterList& list) {
    list.add("lanes", lanes, {1, 64}, "entries/cycle", "checkpoint entries taken from lanes in a cycle", kOurs);
    list.add("write_queue", write_queue, {2, kMaxEntries}, "sectors", "checkpoint sectors waiting to be written",
             kOurs);
    list.add("write_combine", write_combine, "a lane's entries gather in its open sectors before they are written",
             kOurs);
    list.add("open_sectors", open_sectors, {1, 8}, "sectors",
             "of a lane, with write_combine, in which entries of as many checkpoint bins gather", kOurs);
    list.add("read_buffer", read_buffer, "a lane keeps the last sector it replayed", kOurs);
    list.add("entry_bytes", entry_bytes, {8, 28}, "B",
             "checkpoint entry in memory, 8, 16, 20 or 28 (checkpoint_unit.md)",
             from_paper("GRTX, Section IV-B: 8 + 8 + 4"));
    list.add("traffic", traffic,
             "whether entries are written to memory and read from it, or kept at no cost but `lanes`; uncharged is an "
             "assumption, no hardware",
             kOurs);
    list.add("implementation", implementation, kUnitImplementations, kOurs);
    list.rule(
        "entry_bytes", [this] { return allows_entry_bytes(entry_bytes); }, kEntryBytesRule);
  }
  static constexpr const char* kEntryBytesRule = "must be 8, 16, 20 or 28";
  static bool allows_entry_bytes(unsigned bytes) { return bytes == 8 || bytes == 16 || bytes == 20 || bytes == 28; }
};
/// The part's row in the table of all parts.
PartInfo part_info(const CheckpointConfig& config);

struct CheckpointCounters {
  std::uint64_t entries_written = 0, entries_read = 0, sectors_written = 0, sectors_read = 0;
  std::uint64_t acknowledged = 0, returned = 0;  ///< responses to writes and reads
  std::uint64_t straddling_written = 0, straddling_read = 0;
  std::uint64_t max_entries = 0, blocked_cycles = 0;
  static const CounterTable<CheckpointCounters>& table();
  void add(const CheckpointCounters& other) { table().add(*this, other); }
  void describe(StatisticList& list, const std::string& prefix) const { table().describe(*this, list, prefix); }
};

}  // namespace grtx::modules
