// The paper's hardware-cost table, field by field, and the buffers of checkpointing in global memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/modules/kernel/inventory.h"

namespace grtx::sim {

/// What the paper's table counts in an RT unit, from the inventory of its warp buffer (the entries that are marked as
/// added by GRTX). At W warps of 32 lanes: 132 W + 18 bytes.
struct CheckpointStorage {
  struct Field {
    std::string name;
    std::uint64_t bits = 0;
  };
  std::vector<Field> fields;
  std::uint64_t bits = 0;
  /// The table packs flags, so the sum is a whole number of bytes for any even number of lanes.
  std::uint64_t bytes() const { return (bits + 7) / 8; }
};
CheckpointStorage checkpoint_storage(const std::vector<modules::Inventory>& rt_unit);

/// Checkpoint and eviction buffers of all rays in flight. The paper fixes the entries' sizes and the totals; how a
/// ray's bytes divide is open: 97.68 MiB over 8 SMs x 32 warps x 32 lanes leave 5 Nc + Ne = 1,563 (facts of the paper's
/// table, truncated), e.g. 256 checkpoint and 283 eviction entries.
struct BufferSizes {
  unsigned sms = 8;
  unsigned resident_warps = 32;
  unsigned lanes = 32;
  std::uint64_t checkpoint_entries = 256;
  std::uint64_t eviction_entries = 283;
  unsigned checkpoint_copies = 2;  ///< source and destination
  unsigned checkpoint_entry_bytes = 20;
  unsigned eviction_entry_bytes = 8;

  std::uint64_t bytes_per_ray() const {
    return checkpoint_copies * checkpoint_entries * checkpoint_entry_bytes + eviction_entries * eviction_entry_bytes;
  }
  std::uint64_t bytes() const { return std::uint64_t{sms} * resident_warps * lanes * bytes_per_ray(); }
};

}  // namespace grtx::sim
