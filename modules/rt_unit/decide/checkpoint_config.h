// The parameters of checkpoint buffers: what an entry is, and what moves it. The checkpoint unit, its layout without
// time and the memory map ask here.
#pragma once

#include <array>
#include <cstdint>

#include "grtx/base/declare/named_enum.h"
#include "grtx/modules/kernel/declare.h"
#include "grtx/modules/messages/traffic_charging.h"
#include "grtx/modules/rt_unit/decide/unit_implementation.h"

namespace grtx::modules {

/// An SRAM of the RT unit that holds the first entries of both buffers of every resident ray, in place of memory. Each
/// ray has its places there for good: no allocation, no tags, and the address is a concatenation of bits.
struct CheckpointStoreConfig {
  static constexpr unsigned kMaxPorts = 8;
  unsigned entries = 0;  ///< of each buffer; those behind lie in memory
  unsigned latency = 4;
  unsigned read_ports = 1;  ///< beside the one for writing
  unsigned warps = 32;      ///< resident ones that the RT unit serves; by the assembly
  void parameters(ParameterList& list) {
    list.add("checkpoint_entries", entries, {0, 4096}, "entries",
             "of each of a ray's two checkpoint buffers in an SRAM of the RT unit; those behind lie in memory", kOurs)
        .came_later();
    list.add("latency", latency, {1, kMaxLatency}, "cycles", "of a read of that SRAM",
             assumed("access of some 100 KB by the cost model, and the way there and back"))
        .came_later();
    list.add("read_ports", read_ports, {1, kMaxPorts}, "entries/cycle", "of that SRAM, beside one to write", kOurs)
        .came_later();
  }
};

struct CheckpointConfig {
  unsigned lanes = 4;  ///< or last sectors
  unsigned write_queue = 16;
  bool write_combine = false;  ///< else each entry writes every sector it touches
  unsigned open_sectors = 1;   ///< of a lane, with write_combine; two buffers need one
  bool read_buffer = false;    ///< else each entry reads every sector it touches
  unsigned entry_bytes = 20;   ///< 8, 16, 20 or 28
  CheckpointStoreConfig store;
  TrafficCharging traffic = TrafficCharging::charged;
  UnitImplementation implementation = UnitImplementation::tlm;
  /// But for the store, which is a table of its own.
  void parameters(ParameterList& list) {
    list.add("lanes", lanes, {1, 64}, "entries/cycle", "checkpoint entries taken from lanes in a cycle", kOurs);
    list.add("write_queue", write_queue, {2, kMaxEntries}, "sectors", "checkpoint sectors waiting to be written",
             kOurs);
    list.add("write_combine", write_combine, "a lane's entries gather in its open sectors before they are written",
             kOurs);
    list.add("open_sectors", open_sectors, {1, 8}, "sectors",
             "of a lane, with write_combine, in which entries of as many checkpoint bins gather", kOurs)
        .came_later();
    list.add("read_buffer", read_buffer, "a lane keeps the last sector it replayed", kOurs);
    list.add("entry_bytes", entry_bytes, {8, 28}, "B",
             "checkpoint entry in memory, 8, 16, 20 or 28 (checkpoint_unit.md)",
             from_paper("GRTX, Section IV-B: 8 + 8 + 4"))
        .came_later();
    list.add("traffic", traffic,
             "whether entries are written to memory and read from it, or kept at no cost but `lanes`; uncharged is an "
             "assumption, no hardware",
             kOurs)
        .came_later();
    list.add("implementation", implementation, kUnitImplementations, kOurs).came_later();
    list.rule(
        "entry_bytes", [this] { return allows_entry_bytes(entry_bytes); }, kEntryBytesRule);
    list.rule(
        "traffic", [this] { return allows_traffic(); },
        "uncharged needs no private store: there is nothing left to save; charged takes it");
  }
  bool allows_traffic() const { return traffic == TrafficCharging::charged || store.entries == 0; }
  static constexpr const char* kEntryBytesRule = "must be 8, 16, 20 or 28";
  static bool allows_entry_bytes(unsigned bytes) { return bytes == 8 || bytes == 16 || bytes == 20 || bytes == 28; }
};

}  // namespace grtx::modules
