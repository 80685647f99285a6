// SPDX-License-Identifier: Apache-2.0
// Encodes the traversal of a group's rays while it happens: each stack pop as an operation on a child of a known node.
// The caller maintains the stack and the checkpoint buffers, as ChildPlace values.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "grtx/traces/byte_stream.h"
#include "grtx/traces/codec/columns.h"
#include "grtx/traces/codec/dictionary_encoder.h"
#include "grtx/traces/codec/group_codec.h"
#include "grtx/traces/codec/group_model.h"
#include "grtx/traces/codec/group_place.h"
#include "grtx/traces/codec/processed_coder.h"
#include "grtx/traces/count_totals.h"
#include "grtx/traces/encode/encoded_group.h"
#include "grtx/traces/event.h"
#include "grtx/traces/header.h"
#include "grtx/traces/node_source.h"
#include "grtx/traces/rules/round_rules.h"

namespace grtx::traces {

/// A child of a node of the group's model, on a stack or in a checkpoint buffer. On a stack it also holds how its pop
/// differs from the expected one.
class ChildPlace {
 public:
  static constexpr std::uint32_t kMaxNodes = 1U << 25;

  ChildPlace() = default;
  ChildPlace(std::uint32_t parent, unsigned slot) : packed_(parent << 7 | slot << 4) {}
  /// rank: number of siblings on the stack that are expected first. crosses: 1 for a leaf where an inner node is
  /// expected, or the reverse.
  ChildPlace(std::uint32_t parent, unsigned slot, unsigned rank, unsigned crosses)
      : packed_(parent << 7 | slot << 4 | rank << 1 | crosses) {}

  std::uint32_t parent() const { return packed_ >> 7; }
  unsigned slot() const { return packed_ >> 4 & 7; }
  unsigned rank() const { return packed_ >> 1 & 7; }
  unsigned crosses() const { return packed_ & 1; }

 private:
  std::uint32_t packed_ = 0;
};

/// Encodes one group at a time; use one per thread; reuses its memory. Does not check that the operations form a valid
/// traversal. Throws std::logic_error if a limit of the format is exceeded.
class PopEncoder {
 public:
  PopEncoder() = default;
  PopEncoder(const PopEncoder&) = delete;
  PopEncoder& operator=(const PopEncoder&) = delete;

  /// Begins a group whose root is of kind `root`. `header` and `nodes` must stay valid until finish().
  void begin(const Header& header, std::uint32_t index, RayKind kind, NodeKind root, const NodeSource& nodes);
  /// Sets all nodes of the group, ascending by address, before its first ray; the NodeSource is then not used.
  void list(const std::vector<NodeDefinition>& nodes) { dictionary_.list(nodes); }
  /// Ends the group and stores it in `group`.
  void finish(EncodedGroup& group);

  /// Begins the next ray, in lane order.
  void begin_ray();
  void end_ray(std::uint32_t pixel, std::size_t rounds, std::span<const Processed> processed);
  void begin_round() { counts_ = RoundCounts{}; }
  void end_round(const Round& round);

  /// Makes room for `pops` more pops and source entries. The functions below do not check.
  void reserve(std::size_t pops);

  /// Pop and visit of a leaf. checkpoints: Event::checkpoints.
  void leaf(ChildPlace at, LeafOutcome outcome, unsigned checkpoints, unsigned shifts) {
    static constexpr std::uint8_t kOps[8] = {0, 1, 2, 3, 4, 5, 6, kLeafNearest};
    const auto kind = static_cast<unsigned>(outcome);
    unsigned op = kOps[kind];
    ++counts_.leaves[kind];
    if (may_shift(outcome)) {
      put(at, op, 0, kLeaves);
      columns_.put_varint(Column::shifts, shifts);
      if (hides_) columns_.put_varint(Column::shifts, checkpoints);
      return;
    }
    if (checkpoints != 0) op = kLeafBeyondCheckpointed;
    counts_.written += checkpoints;
    put(at, op, 0, kLeaves);
  }
  /// Pop and visit of an instance leaf.
  void instance(ChildPlace at) {
    ++counts_.instances;
    put(at, static_cast<unsigned>(InnerOp::visit), 0, kInner);
  }
  /// Visit of the instance leaf above a node taken from a checkpoint buffer; it pops nothing.
  void instance_of_taken() { ++counts_.instances; }
  void cull(ChildPlace at, unsigned checkpoints) {
    const NodeModel& parent = model_[at.parent()];
    const unsigned inner = (parent.internal_mask | parent.instance_mask) >> at.slot() & 1;
    ++counts_.culls;
    counts_.written += checkpoints;
    const unsigned op = inner != 0 ? static_cast<unsigned>(InnerOp::cull_dropped) : kLeafCullDropped;
    put(at, op + checkpoints, 0, inner != 0 ? kInner : kLeaves);
  }
  /// Model index of the internal node at `address` (in units), which is the child `at`. Call right before internal().
  std::uint32_t reach(ChildPlace at, std::uint32_t address) {
    const std::uint32_t index = model_[at.parent()].links[at.slot()];
    return index != NodeModel::kUnknownLink ? index : reach_first(at, address);
  }
  /// Pop and visit of an internal node, with the masks of the pushed and the checkpointed children.
  void internal(ChildPlace at, std::uint32_t index, unsigned pushed, unsigned checkpoints) {
    const unsigned hits = pushed | checkpoints;
    if (reached_) {
      reached_ = false;
      dictionary_.visit_first(index, hits);
    }
    NodeModel& node = model_[index];
    const unsigned changed = hits ^ node.last_hits;
    node.last_hits = static_cast<std::uint8_t>(hits);
    std::uint8_t*& hits_end = columns_.end(Column::hits);
    *hits_end = static_cast<std::uint8_t>(changed);
    hits_end += changed != 0 ? 1 : 0;
    ++counts_.internal;
    InnerOp op = InnerOp::visit;
    if (checkpoints != 0) {
      op = InnerOp::visit_with_checkpoints;
      counts_.written += bits_of_byte(checkpoints);
      // A single hit needs no mask, since it must be the checkpointed one.
      if (!has_one_bit(hits)) columns_.put(Column::checkpoints, gather_bits(checkpoints, hits));
    }
    put(at, static_cast<unsigned>(op), changed != 0 ? kPopHits : 0, kInner);
  }
  /// Reads of source entries, while the stack is empty.
  void take() { read(ReplayOp::take); }
  void forward(unsigned checkpoints) {
    counts_.written += checkpoints;
    read(checkpoints != 0 ? ReplayOp::forward_checkpointed : ReplayOp::forward_dropped);
  }
  /// The round ends although its bins have more entries to read.
  void stop() { columns_.put(Column::replay_op, static_cast<unsigned>(ReplayOp::stop)); }
  /// Read order of a replay, before its events; takes the room of one pop.
  void bin_order(const BinOrder& order) {
    bin(order.first);
    bin(order.before_far);
  }
  /// Bin of a written checkpoint entry.
  void bin(unsigned bin) { columns_.put(Column::bin, bin); }
  /// For read order nearest: the entry's position minus (last read position + 1).
  void source_position(std::int64_t difference) { columns_.put_varint(Column::replay_entry, zigzag(difference)); }

  /// Expected pop order of a node's children (NodeModel::order).
  std::uint64_t order(std::uint32_t index) const { return model_[index].order; }
  /// The child in `slot` will be popped first among `remaining`. Updates the expected order if another was expected.
  ChildPlace pop(std::uint32_t parent, unsigned remaining, unsigned slot) {
    NodeModel& node = model_[parent];
    const unsigned first = NodeModel::first_of(node.ordered(remaining));
    if (first == slot) return {parent, slot};
    const unsigned inner = node.internal_mask | node.instance_mask;
    const ChildPlace place(parent, slot, node.rank_of(remaining, slot), (inner >> slot ^ inner >> first) & 1);
    node.move_up(remaining, slot);
    return place;
  }
  /// The same for all pushed children of a node; the last of `stack` is popped first.
  void pop_all(std::span<ChildPlace> stack);

  const GroupModel& model() const { return model_; }
  GroupPlace& place() { return place_; }

 private:
  static constexpr unsigned kLeaves = 0, kInner = 1;

  struct Symbols {
    Bytes bytes;
    std::uint8_t* end = nullptr;
  };

  /// Appends to the symbols of the kind of child (leaf or inner) that was expected.
  void put(ChildPlace at, unsigned op, unsigned changed_hits, unsigned kind) {
    std::uint8_t& last = model_[at.parent()].last_op[at.slot()];
    const unsigned symbol = (op ^ last) | at.rank() << kPopRankShift | changed_hits;
    last = static_cast<std::uint8_t>(op);
    *symbols_[kind ^ at.crosses()].end++ = static_cast<std::uint8_t>(symbol);
  }
  void read(ReplayOp op) {
    ++counts_.read;
    columns_.put(Column::replay_op, static_cast<unsigned>(op));
  }
  std::uint32_t reach_first(ChildPlace at, std::uint32_t address);
  void put_pops(Column gaps, Column symbols, Symbols& pops, unsigned& run);
  void end_gap(Column column, unsigned run);

  const Header* header_ = nullptr;
  RayKind kind_ = RayKind::primary;
  NodeKind root_ = NodeKind::internal;
  bool nearest_ = false;
  bool bins_ = false;
  bool hides_ = false;    ///< the header's opacity_bound
  bool reached_ = false;  ///< the current visit reached its node for the first time
  std::int64_t last_pixel_ = 0;
  std::size_t rays_ = 0;
  std::uint64_t events_ = 0;
  std::uint64_t in_eviction_buffer_ = 0;
  GroupPlace place_;
  Totals totals_;
  RoundCounts counts_;
  ColumnWriter columns_;
  std::array<Symbols, 2> symbols_;         ///< [kLeaves or kInner] all pops of the ray, including predicted ones
  unsigned inner_run_ = 0, leaf_run_ = 0;  ///< predicted pops since the last mispredicted one
  GroupModel model_;
  DictionaryEncoder dictionary_{model_, place_};
  ProcessedEncoder processed_;
};

}  // namespace grtx::traces
