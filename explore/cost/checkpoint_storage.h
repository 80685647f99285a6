// SPDX-License-Identifier: Apache-2.0
// The paper's hardware-cost table, field by field, and the checkpoint and eviction buffers in global memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "grtx/modules/kernel/inventory.h"
#include "grtx/traces/node_layout.h"

namespace grtx::explore {

/// Storage of one RT unit as counted by the paper's table: the entries of the warp buffer's inventory that are marked
/// as added by GRTX. With W warps of 32 lanes: 132 W + 18 bytes.
struct CheckpointStorage {
  struct Field {
    std::string name;
    std::uint64_t bits = 0;
  };
  std::vector<Field> fields;
  std::uint64_t bits = 0;
  /// Flags are packed, as in the table.
  std::uint64_t bytes() const { return (bits + 7) / 8; }
};
CheckpointStorage checkpoint_storage(const std::vector<modules::Inventory>& rt_unit);

/// Checkpoint and eviction buffers of all rays in flight. The paper gives the entry sizes and the total, not the number
/// of entries: 97.68 MiB over 8 SMs x 32 warps x 32 lanes means 5 Nc + Ne = 1,563 (truncated), for Nc checkpoint and Ne
/// eviction entries per ray. The defaults, 256 and 283, fulfil it.
struct BufferSizes {
  unsigned sms = 8;
  unsigned resident_warps = 32;
  unsigned lanes = 32;
  std::uint64_t checkpoint_entries = 256;
  std::uint64_t eviction_entries = 283;
  unsigned checkpoint_copies = 2;  ///< source and destination
  unsigned checkpoint_entry_bytes = traces::kCheckpointEntryBytes;
  unsigned eviction_entry_bytes = traces::kEvictionEntryBytes;

  std::uint64_t bytes_per_ray() const {
    return checkpoint_copies * checkpoint_entries * checkpoint_entry_bytes + eviction_entries * eviction_entry_bytes;
  }
  std::uint64_t bytes() const { return std::uint64_t{sms} * resident_warps * lanes * bytes_per_ray(); }
};

}  // namespace grtx::explore
