// Whether an entry has the bits for what it names, and how the 32 bits of one of 8 B divide:
// docs/model/checkpoint_unit.md has every layout.
#pragma once

#include "grtx/traces/header.h"

namespace grtx::modules {

/// A node or, of a node inside the shared BLAS, its instance leaf, counted in 64 B from the node image's first byte;
/// and that BLAS node, counted in 64 B from the BLAS header. 0 is the header, so it says that no BLAS node is named.
struct CheckpointEntrySplit {
  unsigned node_bits = 0;
  unsigned blas_bits = 0;   ///< 0: the structure is monolithic
  unsigned scene_bits = 0;  ///< of the leaf of the scene TLAS, counted as nodes are; 0: there is none
};

/// The fewest bits that name every node of the trace's structure.
CheckpointEntrySplit checkpoint_entry_split(const traces::Header& header);

/// Throws Error unless entries of so many bytes can name every node of the trace's structure.
void require_entry_fits(unsigned entry_bytes, const traces::Header& header);

}  // namespace grtx::modules
