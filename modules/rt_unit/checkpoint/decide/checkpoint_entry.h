// SPDX-License-Identifier: Apache-2.0
// Bit widths of the node references in a checkpoint entry: whether they fit, and how an 8 B entry divides its 32 bits.
// All layouts are in docs/model/checkpoint_unit.md.
#pragma once

#include "grtx/traces/header.h"

namespace grtx::modules {

/// An entry names a node by its offset from the start of the node image, in 64 B. A node inside the shared BLAS is
/// named by its instance leaf and its offset from the BLAS header, in 64 B; offset 0, the header, means no BLAS node.
struct CheckpointEntrySplit {
  unsigned node_bits = 0;
  unsigned blas_bits = 0;   ///< 0: the structure is monolithic
  unsigned scene_bits = 0;  ///< for the leaf of the scene TLAS, in the same units as nodes; 0: no scene TLAS
};

/// The minimum widths that can name every node of the trace's acceleration structure.
CheckpointEntrySplit checkpoint_entry_split(const traces::Header& header);

/// Throws Error unless entries of `entry_bytes` can name every node of the trace's acceleration structure.
void require_entry_fits(unsigned entry_bytes, const traces::Header& header);

}  // namespace grtx::modules
