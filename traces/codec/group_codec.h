// SPDX-License-Identifier: Apache-2.0
// Encodes a ray group as the payload of a chunk, and decodes it. docs/model/trace-format.md describes the columns.
#pragma once

#include <cstddef>
#include <cstdint>

#include "grtx/traces/byte_stream.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"

namespace grtx::traces {

/// Appends the group's payload to `out`. Throws like GroupEncoder. Its working memory is thread-local.
void encode_group(const Header& header, const RayGroup& group, Bytes& out);

/// Inverse of encode_group(); the group must have `index`. Throws Malformed on anything that encode_group() does not
/// write, and, with the size in the message, before it would use up the free memory.
void decode_group(const Header& header, const std::uint8_t* payload, std::size_t size, std::uint64_t index,
                  RayGroup& group);

/// Operations on a popped internal node or instance leaf.
enum class InnerOp : std::uint8_t { visit = 0, visit_with_checkpoints = 1, cull_dropped = 2, cull_checkpointed = 3 };
/// Operations on a popped leaf: values below 7 are the LeafOutcome itself.
inline constexpr unsigned kLeafBeyondCheckpointed = 7;
inline constexpr unsigned kLeafCullDropped = 8;
inline constexpr unsigned kLeafCullCheckpointed = 9;
inline constexpr unsigned kLeafNearest = 10;
/// A byte of columns inner and leaf: operation XOR the child's previous one (4 bits), rank (3 bits), and a flag for a
/// byte in column hits.
inline constexpr unsigned kPopOp = 0x0F;
inline constexpr unsigned kPopRankShift = 4;
inline constexpr unsigned kPopHits = 0x80;
/// In inner_gap and leaf_gap: 255 predicted pops that no mispredicted one follows.
inline constexpr unsigned kLongGap = 255;
/// Most pops of one group.
inline constexpr std::uint64_t kMaxPops = 1ULL << 30;
/// Symbols of column replay_op. stop: the round ends although readable entries are left in the bins.
enum class ReplayOp : std::uint8_t { take = 0, forward_dropped = 1, forward_checkpointed = 2, stop = 3 };
/// Bits of column round_flags.
inline constexpr unsigned kRoundReplay = 1;
inline constexpr unsigned kRoundOverflow = 2;
inline constexpr unsigned kRoundTerminated = 4;
/// Bits of column processed.
inline constexpr unsigned kProcessedBlended = 1;
inline constexpr unsigned kProcessedNotPredicted = 2;
/// Node kinds are stored as indices into this list.
inline constexpr NodeKind kStoredKinds[4] = {NodeKind::internal, NodeKind::instance, NodeKind::procedural,
                                             NodeKind::triangle};
/// Bits of column node_shape above the child count (4 bits) and the stored kind of the leaves (2 bits, 0: no leaves).
inline constexpr unsigned kShapeMixed = 0x40;      ///< both internal nodes and leaves: a mask follows
inline constexpr unsigned kShapeIrregular = 0x80;  ///< leaves of several kinds: all kinds follow
inline constexpr unsigned kShapeWide = 0x10;       ///< besides kShapeIrregular: then the mask of wide leaves
/// Packs the bits of `value` selected by `mask` (PEXT); scatter_bits() is the inverse (PDEP).
constexpr unsigned gather_bits(unsigned value, unsigned mask) {
  unsigned gathered = 0;
  for (unsigned place = 0; mask != 0; mask &= mask - 1, ++place) {
    if ((value & mask & (0U - mask)) != 0) gathered |= 1U << place;
  }
  return gathered;
}
constexpr unsigned scatter_bits(unsigned gathered, unsigned mask) {
  unsigned value = 0;
  for (; mask != 0; mask &= mask - 1, gathered >>= 1) {
    if ((gathered & 1) != 0) value |= mask & (0U - mask);
  }
  return value;
}
/// How the dictionary is stored: flags in column group.
inline constexpr unsigned kNodesInTree = 1;        ///< as a tree, not by address
inline constexpr unsigned kNodesHoldRoot = 2;      ///< the tree contains the root
inline constexpr unsigned kNodesHoldBlasRoot = 4;  ///< the tree contains the BLAS root
/// No prediction for the next processed Gaussian.
inline constexpr std::uint32_t kNoSuccessor = 0xFFFFFFFF;

}  // namespace grtx::traces
